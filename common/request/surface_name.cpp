#include "common/request/surface_name.hpp"

namespace multitetra {

SurfaceName surface_name(const DatasetInfo& info) {
  if (!info.member || !info.member->label) return {.text = info.name};
  const Label& label = *info.member->label;
  return {.text = label.name.empty() ? info.name : label.name, .label = label.value};
}

}  // namespace multitetra
