// A field of a request has the same name in options, HTTP, Python, protobuf and the viewer's
// address. Python's keywords are made from the table; tests/client/python/package_test.py compares
// them with the options.
#include <gtest/gtest.h>

#include <cctype>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>
#include <string>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "common/base/number_text.hpp"
#include "common/cli/surface_options.hpp"
#include "common/dataset/dataset_fields.hpp"
#include "common/request/default_error.hpp"

namespace multitetra {
namespace {

using Names = std::set<std::string>;

std::string text_of_file(const std::string& path) {
  std::ifstream file(std::string(MULTITETRA_TEST_DATA) + "/../../" + path);
  std::ostringstream text;
  text << file.rdbuf();
  EXPECT_FALSE(text.str().empty()) << path;
  return text.str();
}

// Returns what the expression's first group matches, for all matches in the text.
Names matches(const std::string& text, const std::string& expression) {
  const std::regex pattern(expression);
  Names found;
  for (std::sregex_iterator at(text.begin(), text.end(), pattern), end; at != end; ++at) {
    found.insert((*at)[1]);
  }
  return found;
}

Names fields(const std::function<bool(const RequestField&)>& is_wanted) {
  Names names;
  for (const RequestField& field : request_fields()) {
    if (is_wanted(field)) names.insert(std::string(field.name));
  }
  return names;
}

std::string kebab(std::string name) {
  std::replace(name.begin(), name.end(), '_', '-');
  return name;
}

std::string snake(const std::string& camel) {
  std::string name;
  for (const char c : camel) {
    if (std::isupper(static_cast<unsigned char>(c)) != 0) name += '_';
    name += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return name;
}

TEST(RequestNames, MatchTheOptions) {
  Command command("", "test");
  SurfaceArguments arguments;
  add_request_options(command, arguments,
                      {FieldGroup::kSurface, FieldGroup::kThresholds, FieldGroup::kSize,
                       FieldGroup::kColors, FieldGroup::kFile});
  const std::string help = command.app().help("", CLI::AppFormatMode::All);
  Names expected = {"threshold-grid", "help"};
  for (const std::string& name : fields([](const RequestField&) { return true; })) {
    expected.insert(kebab(name));
  }
  EXPECT_EQ(matches(help, "--([a-z-]+)"), expected);
}

TEST(RequestNames, HaveOneDefaultError) {
  const Names one = {shortest_text(kDefaultError)};
  EXPECT_EQ(kDefaultError, quality_error_from("fine"));
  for (const RequestField& field : request_fields()) {
    if (field.name != "error") continue;
    EXPECT_EQ(Names{std::string(field.default_text)}, one);
  }
  const std::string number = "(\\d[.\\d]*)";
  EXPECT_EQ(matches(text_of_file("proto/multitetra/v1/request.proto"),
                    "ThresholdMap threshold = 2;\\s+// Absent means " + number + " voxels"),
            one);
  EXPECT_EQ(matches(text_of_file("proto/multitetra/v1/request.proto"),
                    "// full-resolution surface. Absent means " + number +
                        "\\.\n  optional double error"),
            one);
  EXPECT_EQ(matches(text_of_file("client/web/src/state/settings.ts"),
                    "\n  error: setting\\(format.number\\(0, 1e6\\), " + number),
            one);
  EXPECT_EQ(matches(text_of_file("client/python/multitetra/napari_reader.py"),
                    "get\\(\"error\", " + number + "\\)"),
            one);
}

TEST(RequestNames, MatchProtobuf) {
  const std::string proto = text_of_file("proto/multitetra/v1/request.proto");
  Names names;
  for (const std::string message : {"ThresholdMap", "IsosurfaceRequest"}) {
    const std::size_t begin = proto.find("message " + message + " {");
    const std::string body = proto.substr(begin, proto.find("\n}\n", begin) - begin);
    names.merge(matches(body, "\n  (?:repeated |optional )?\\w+ (\\w+) = \\d+;"));
  }
  Names expected = fields([](const RequestField& field) {
    const bool is_in_request =
        field.group != FieldGroup::kColors && field.group != FieldGroup::kFile;
    return is_in_request && field.name != "quality" && field.name != "region";
  });
  // Lists have plural names, a quality is sent as an error, and the other fields have no option.
  expected.merge(Names{"regions", "threshold", "threshold_grid", "at_least", "cell"});
  EXPECT_EQ(names, expected);
}

TEST(DatasetNames, MatchProtobuf) {
  const std::string proto = text_of_file("proto/multitetra/v1/dataset.proto");
  const std::size_t begin = proto.find("message DatasetInfo {");
  const std::string body = proto.substr(begin, proto.find("\n}\n", begin) - begin);
  Names expected = {"content_id"};
  const DatasetInfo info;
  visit_dataset_fields(
      info, [&](const DatasetField& field, const auto&) { expected.insert(field.name); });
  EXPECT_EQ(matches(body, "\n  (?:repeated |optional )?\\w+ (\\w+) = \\d+;"), expected);
}

TEST(RequestNames, MatchTheViewersAddress) {
  const std::string settings = text_of_file("client/web/src/state/settings.ts");
  Names viewer;
  for (const std::string& name :
       matches(settings, "\n  (\\w+): (?:setting|optional|onOff|share)\\(")) {
    viewer.insert(snake(name));
  }
  viewer.merge(
      matches(text_of_file("client/web/src/state/url_state.ts"), "setting === \"(quality)\""));
  const Names not_in_viewer = {"color_anyway", "unit",        "lattice",     "region_coordinates",
                               "view",         "combine",     "max_bytes",   "intersection_free",
                               "normals",      "color_range", "color_scale", "coordinates",
                               "codec"};
  for (const std::string& name : fields([](const RequestField&) { return true; })) {
    EXPECT_NE(viewer.contains(name), not_in_viewer.contains(name)) << name;
  }
}

}  // namespace
}  // namespace multitetra
