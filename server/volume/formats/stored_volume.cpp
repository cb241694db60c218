#include "server/volume/formats/stored_volume.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/address_text.hpp"
#include "common/base/number_text.hpp"
#include "common/base/parse_number.hpp"
#include "common/base/text.hpp"
#include "common/base/utf8.hpp"
#include "common/base/vec3.hpp"

namespace multitetra {

namespace fs = std::filesystem;

void fail_reading(const fs::path& file, const std::string& problem, const std::string& remedy) {
  constexpr std::size_t kMaxBytes = 4000;
  std::string text = printable(
      "Cannot read '" + without_password(file.string()) + "': " + problem + ". " + remedy + ".",
      /*keeps_lines=*/false);
  if (text.size() > kMaxBytes) text = text.substr(0, kMaxBytes) + "...";
  throw VolumeFileError(text);
}

void fail_incomplete(const fs::path& file, const std::string& problem) {
  fail_reading(file, problem, "Get a complete copy of the file");
}

void fail_damaged(const fs::path& file, const std::string& problem) {
  fail_reading(file, problem, "Compare it with another copy, or check the program that wrote it");
}

std::optional<ComponentChoice> ComponentChoice::from(std::string_view text) {
  if (text == "magnitude") return ComponentChoice{.kind = Kind::kMagnitude};
  if (text == "luminance") return ComponentChoice{.kind = Kind::kLuminance};
  const auto index = parse_number<int>(text);
  if (!index || *index < 0) return std::nullopt;
  return ComponentChoice{.kind = Kind::kIndex, .index = *index};
}

std::int64_t chosen_entry(const fs::path& file, const FileEntries& entries,
                          std::optional<std::int64_t> wanted, bool takes_first) {
  if (entries.count < 1) fail_damaged(file, entries.several);
  if (entries.count != 1 && !wanted && !takes_first) {
    fail_reading(file, entries.several, entries.remedy);
  }
  const std::int64_t entry = wanted.value_or(0);
  if (entry >= 0 && entry < entries.count) return entry;
  fail_reading(file, entries.missing + " " + std::to_string(entry),
               "Choose 0 to " + std::to_string(entries.count - 1));
}

std::int64_t chosen_time(const fs::path& file, std::int64_t count, const VolumeChoice& choice) {
  return chosen_entry(file,
                      {.count = count,
                       .several = "it has " + std::to_string(count) + " volumes, one for each time",
                       .remedy = kChooseTime},
                      choice.time, choice.first);
}

void check_header(const fs::path& file, const ImageHeader& header) {
  for (const std::int64_t side : header.dims) {
    if (side >= 1 && side <= kMaxSide) continue;
    fail_reading(file, "it has " + sides_text(header.dims) + " samples",
                 "Each side must have 1 to " + std::to_string(kMaxSide) + " samples");
  }
  if (header.components < 1 || header.components > kMaxComponents) {
    fail_reading(file, "each sample has " + std::to_string(header.components) + " components",
                 "It must have 1 to " + std::to_string(kMaxComponents));
  }
  if (!std::isfinite(header.slope) || header.slope == 0 || !std::isfinite(header.intercept)) {
    fail_reading(file,
                 "its slope " + rounded_text(header.slope) + " and intercept " +
                     rounded_text(header.intercept) + " are invalid",
                 "Correct the header: the slope must not be 0, and both must be finite");
  }
  const auto& [x, y, z] = header.geometry.axes;
  const double volume = dot(cross(x, y), z);
  if (!std::isfinite(volume) || volume == 0) {
    fail_reading(file, "its axis directions are linearly dependent",
                 "Correct the header: the three directions must be independent");
  }
}

std::string choice_notice(const fs::path& file, std::size_t count, const std::string& kind,
                          const std::string& used, const std::string& option) {
  return "'" + without_password(file.string()) + "': of its " + std::to_string(count) + " " + kind +
         ", " + used + " is used; select another with " + option + ".";
}

void offer_images(const fs::path& file, const std::string& kind,
                  const std::vector<std::string>& images, const VolumeChoice& choice,
                  StoredVolume& volume) {
  if (images.size() < 2) return;
  volume.series = std::ssize(images);
  for (std::size_t i = 0; i < images.size(); ++i) {
    volume.contents.entries.push_back({.kind = kind,
                                       .name = images[i],
                                       .detail = {},
                                       .option = "--series " + std::to_string(i + 1)});
  }
  if (choice.series.empty()) {
    volume.notices.push_back(
        choice_notice(file, images.size(), kind + "s", images.front(), "--series, from 1"));
  }
}

void note_palette(ImageHeader& header) {
  header.contradictions.push_back(
      {Fact::kScaling, "its numbers are indices of a color palette; they are read as stored"});
}

std::string unread_notice(const fs::path& file, std::uint64_t bytes) {
  return "'" + without_password(file.string()) + "': " + std::to_string(bytes) +
         (bytes == 1 ? " byte" : " bytes") + " behind its samples are not read.";
}

void ras_to_lps(ImageHeader& header, std::array<Vec3, 3>& steps, Vec3& origin) {
  header.turned_by = {-1, -1, 1};
  for (Vec3* vector : {&steps[0], &steps[1], &steps[2], &origin}) {
    (*vector)[0] = 0 - (*vector)[0];
    (*vector)[1] = 0 - (*vector)[1];
  }
}

fs::path named_data_place(const fs::path& header, const std::string& name,
                          bool allow_external_files) {
  const fs::path folder = header.has_parent_path() ? header.parent_path() : fs::path(".");
  const fs::path file = folder / name;
  std::error_code error;
  const fs::path inside =
      fs::weakly_canonical(file, error).lexically_relative(fs::weakly_canonical(folder, error));
  if (!allow_external_files && (error || inside.empty() || *inside.begin() == "..")) {
    fail_reading(
        header, "it refers to the data file '" + name + "', which is outside the header's folder",
        "Put the data beside the header, or allow it with --follow if you trust the header");
  }
  if (!fs::exists(file, error)) {
    fail_reading(header, "its data file '" + name + "' is missing",
                 "Put the data file beside the header");
  }
  return file;
}

fs::path named_data_file(const fs::path& header, const std::string& name,
                         bool allow_external_files) {
  fs::path file = named_data_place(header, name, allow_external_files);
  std::error_code error;
  if (!fs::is_regular_file(file, error)) {
    fail_reading(header, "its data file '" + name + "' is not a regular file",
                 "Give a header whose samples are in a file");
  }
  return file;
}

}  // namespace multitetra
