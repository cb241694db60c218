// Tables of labels' names and colours, as segmentation programs write them.
#include <cstdint>
#include <set>
#include <string_view>

#include "server/dataset/families/label_names.hpp"
#include "tests/fuzz/require.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace multitetra;
  const auto labels = parse_label_names({reinterpret_cast<const char*>(data), size});
  if (!labels) {
    require(labels.error().text.starts_with("line "));
    return 0;
  }
  std::set<double> values;
  for (const Label& label : *labels) {
    require(values.insert(label.value).second);
    require(check_member({.family = "labels", .label = label}).has_value());
  }
  return 0;
}
