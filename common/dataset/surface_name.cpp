#include "common/dataset/surface_name.hpp"

namespace multitetra {

SurfaceName surface_name(const DatasetInfo& info) {
  SurfaceName name{.text = info.name};
  if (!info.member) return name;
  name.color = display_color(*info.member);
  const auto& label = info.member->label;
  if (!label) return name;
  name.label = label->value;
  if (!label->name.empty()) name.text = label->name;
  return name;
}

}  // namespace multitetra
