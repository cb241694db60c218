#include "common/dataset/tissues.hpp"

namespace multitetra {

bool is_ct(const DatasetInfo& info) {
  if (info.meaning.value_unit == "HU") return true;
  return info.meaning.value_unit.empty() && info.min >= -3100 && info.min <= -900 &&
         info.max >= 700 && info.max <= 40000;
}

std::string_view tissue_at(double isovalue, const DatasetInfo& info) {
  if (!is_ct(info) || isovalue < -500) return {};
  if (isovalue < -150) return "skin";
  if (isovalue < 130) return "soft tissue";
  return isovalue < 2000 ? "bone" : "enamel, metal";
}

}  // namespace multitetra
