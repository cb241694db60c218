// Tables of label names and colors, as written by segmentation programs: as separate files, and in
// NRRD headers.
#include <cstdint>
#include <set>
#include <string_view>

#include "server/volume/formats/detail/segment_names.hpp"
#include "server/volume/formats/stored_volume.hpp"
#include "server/volume/labels/label_names.hpp"
#include "tests/fuzz/require.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace multitetra;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  std::set<double> numbers;
  for (const SourceLabel& segment : segments_in(text)) {
    require(numbers.insert(segment.label.value).second);
    require(segment.layer >= 0 && segment.layer < kMaxComponents);
    require(check_member({.series = "segments", .label = segment.label}).has_value());
  }
  const auto labels = parse_label_names(text);
  if (!labels) {
    require(labels.error().text.starts_with("line "));
    return 0;
  }
  std::set<double> values;
  for (const Label& label : *labels) {
    require(values.insert(label.value).second);
    require(check_member({.series = "labels", .label = label}).has_value());
  }
  return 0;
}
