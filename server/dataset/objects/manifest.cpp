#include "server/dataset/objects/manifest.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <charconv>
#include <optional>
#include <span>
#include <utility>

#include "server/dataset/checksum.hpp"
#include "server/dataset/prepared_format.hpp"

namespace multitetra {
namespace {

using ManifestJson = nlohmann::json;

constexpr const char* kFormat = "multitetra-objects";
constexpr std::size_t kMostManifestBytes = std::size_t{16} << 20;
constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 56;  // Of anything: sums stay in range.

std::string hex_of(std::uint64_t number) {
  std::string digits(16, '0');
  for (std::size_t i = digits.size(); i-- > 0; number >>= 4) {
    digits[i] = "0123456789abcdef"[number & 15];
  }
  return digits;
}

std::optional<std::uint64_t> number_from_hex(std::string_view text) {
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number, 16);
  if (text.size() != 16 || error != std::errc() || end != text.data() + text.size()) {
    return std::nullopt;
  }
  return number;
}

ManifestJson json_of(const ObjectRun& run) {
  ManifestJson names = ManifestJson::array();
  for (const ObjectName& name : run.objects) names.push_back(name.hex());
  return {{"bytes", run.bytes}, {"objects", std::move(names)}};
}

// Of the text without that field: compact, keys in the order of the alphabet.
std::string checksum_of(ManifestJson json) {
  json.erase("checksum");
  const std::string text = json.dump();
  return hex_of(checksum(std::as_bytes(std::span(text))));
}

tl::unexpected<Error> bad_manifest(const std::string& what) {
  return fail(ErrorCode::kDamagedData, "The manifest " + what + " Convert the dataset again.");
}

// Reads fields; the first one that is not what it must be is remembered.
class ManifestReader {
 public:
  [[nodiscard]] const std::string& trouble() const { return trouble_; }
  void complain(std::string what) {
    if (trouble_.empty()) trouble_ = std::move(what);
  }

  std::uint64_t bytes(const ManifestJson& object, const char* key) {
    const auto found = object.is_object() ? object.find(key) : object.end();
    if (!object.is_object() || found == object.end() || !found->is_number_unsigned() ||
        found->get<std::uint64_t>() > kMostBytes) {
      complain(std::string("has no size in field \"") + key + "\".");
      return 0;
    }
    return found->get<std::uint64_t>();
  }
  std::string text(const ManifestJson& object, const char* key) {
    const auto found = object.is_object() ? object.find(key) : object.end();
    if (!object.is_object() || found == object.end() || !found->is_string()) {
      complain(std::string("has no text in field \"") + key + "\".");
      return {};
    }
    return found->get<std::string>();
  }
  ObjectRun run(const ManifestJson& manifest, const char* key) {
    static const ManifestJson kNothing;
    const ManifestJson& object = manifest.contains(key) ? manifest.at(key) : kNothing;
    ObjectRun run{.bytes = bytes(object, "bytes"), .objects = {}};
    if (!trouble_.empty()) return run;
    if (!object.contains("objects") || !object.at("objects").is_array() ||
        object.at("objects").size() != (run.bytes + kRunObjectBytes - 1) / kRunObjectBytes) {
      complain(std::string("names more or fewer objects in \"") + key +
               "\" than it has bytes for.");
      return run;
    }
    std::uint64_t left = run.bytes;
    for (const ManifestJson& digest : object.at("objects")) {
      const std::uint64_t size = std::min<std::uint64_t>(left, kRunObjectBytes);
      const auto name = digest.is_string()
                            ? ObjectName::from(digest.get_ref<const std::string&>(), size)
                            : std::nullopt;
      if (!name) {
        complain(std::string("has a name in \"") + key + "\" that is none.");
        return run;
      }
      run.objects.push_back(*name);
      left -= size;
    }
    return run;
  }
  SectionTable sections(const ManifestJson& manifest) {
    SectionTable table;
    if (!manifest.contains("sections") || !manifest.at("sections").is_array() ||
        manifest.at("sections").size() > kMaxSections) {
      complain("has no list of sections.");
      return table;
    }
    std::uint64_t end = kHeadBytes;
    for (const ManifestJson& object : manifest.at("sections")) {
      const bool is_large = is_large_section(text(object, "name"));
      const auto sum =
          is_large ? std::optional<std::uint64_t>(0) : number_from_hex(text(object, "checksum"));
      Section section{.name = text(object, "name"),
                      .required = true,
                      .offset = section_begin(end),
                      .size = bytes(object, "bytes"),
                      .checksum = sum.value_or(0)};
      if (object.contains("required") && object.at("required").is_boolean()) {
        section.required = object.at("required").get<bool>();
      }
      if (!sum) complain("has a section without a checksum.");
      if (section.name.empty() || section.name.size() > 8)
        complain("has a section without a name.");
      if (find_section(table, section.name) != nullptr) {
        complain("names section \"" + section.name + "\" twice.");
      }
      end = section.offset + section.size;
      table.push_back(std::move(section));
    }
    return table;
  }

 private:
  std::string trouble_;
};

}  // namespace

bool is_large_section(std::string_view name) {
  return name == section_names::kSamples || name == section_names::kSpectrum;
}

std::string content_id_text(const SectionTable& sections) {
  return hex_of(content_id_of(sections));
}

std::string manifest_text(const Manifest& manifest) {
  ManifestJson sections = ManifestJson::array();
  for (const Section& section : manifest.sections) {
    ManifestJson one = {
        {"name", section.name}, {"bytes", section.size}, {"required", section.required}};
    if (!is_large_section(section.name)) one["checksum"] = hex_of(section.checksum);
    sections.push_back(std::move(one));
  }
  ManifestJson json = {
      {"format", kFormat},
      {"version", manifest.shares_objects ? kSharedObjectsVersion : kObjectsVersion},
      {"file_version", kPreparedFormatVersion},
      {"content_id", manifest.content_id},
      {"sections", std::move(sections)},
      {"first", json_of(manifest.first)},
      {"later", json_of(manifest.later)}};
  json["checksum"] = checksum_of(json);
  return json.dump(1) + "\n";
}

Result<Manifest> parse_manifest(std::string_view text) {
  if (text.size() > kMostManifestBytes) return bad_manifest("is longer than 16 MiB.");
  // What lies deeper than ours is left out: it cannot have the checksum, nor use up the stack.
  const auto is_shallow = [](int depth, ManifestJson::parse_event_t, ManifestJson&) {
    return depth <= 4;
  };
  const ManifestJson json = ManifestJson::parse(text, is_shallow, /*allow_exceptions=*/false);
  if (!json.is_object() || !json.contains("format") || json.at("format") != kFormat) {
    return bad_manifest("is no JSON object of format \"" + std::string(kFormat) + "\".");
  }
  ManifestReader reader;
  const std::uint64_t version = reader.bytes(json, "version");
  if ((version != kObjectsVersion && version != kSharedObjectsVersion) ||
      reader.bytes(json, "file_version") != kPreparedFormatVersion) {
    return fail(ErrorCode::kUnsupportedVersion,
                "The manifest has another version than this program reads (" +
                    std::to_string(kObjectsVersion) + " and " +
                    std::to_string(kSharedObjectsVersion) + ", of files of version " +
                    std::to_string(kPreparedFormatVersion) +
                    "). Use a newer program, or convert the dataset again.");
  }
  if (reader.text(json, "checksum") != checksum_of(json)) {
    return bad_manifest("does not have its checksum.");
  }
  Manifest manifest{.content_id = reader.text(json, "content_id"),
                    .sections = reader.sections(json),
                    .first = reader.run(json, "first"),
                    .later = reader.run(json, "later"),
                    .shares_objects = version == kSharedObjectsVersion};
  if (!number_from_hex(manifest.content_id)) reader.complain("has no content_id.");
  if (!reader.trouble().empty()) return bad_manifest(reader.trouble());
  return manifest;
}

}  // namespace multitetra
