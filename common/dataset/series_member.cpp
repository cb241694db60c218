#include "common/dataset/series_member.hpp"

#include <cmath>
#include <cstdio>

#include "common/base/parse_number.hpp"
#include "common/base/utf8.hpp"
#include "common/dataset/physical_meaning.hpp"
#include "common/image/label_color.hpp"

namespace multitetra {
namespace {

constexpr std::uint32_t kWhite = 0xFFFFFF;

Result<void> wrong(const std::string& what) {
  return fail(ErrorCode::kInvalidArgument, "member." + what);
}

Result<void> check_label(const Label& label) {
  if (!(std::abs(label.value) <= kMaxLabelValue) || std::trunc(label.value) != label.value) {
    return wrong("label.value must be a whole number from -2^53 to 2^53.");
  }
  if (label.name.size() > kMaxMemberTextBytes || !is_plain_text(label.name)) {
    return wrong("label.name must be UTF-8 of at most 255 bytes without control characters.");
  }
  if (label.color.value_or(0) > kWhite) return wrong("label.color must be at most 0xffffff.");
  return {};
}

}  // namespace

Result<void> check_member(const SeriesMember& member) {
  const std::string& series = member.series;
  if (series.empty() || series.size() > kMaxMemberTextBytes || !is_plain_text(series) ||
      series.find('/') != std::string::npos) {
    return wrong("series must have 1 to 255 bytes of UTF-8, no '/' and no control characters.");
  }
  if (member.field.size() > kMaxMemberTextBytes || !is_plain_text(member.field)) {
    return wrong("field must be UTF-8 of at most 255 bytes without control characters.");
  }
  if (!std::isfinite(member.time.value_or(0))) return wrong("time must be finite.");
  if (!is_unit_text(member.time_unit)) {
    return wrong("time_unit must be UTF-8 of at most " + std::to_string(kMaxUnitBytes) +
                 " bytes without control characters.");
  }
  if (member.color.value_or(0) > kWhite) return wrong("color must be at most 0xffffff.");
  return member.label ? check_label(*member.label) : Result<void>{};
}

std::optional<std::uint32_t> display_color(const SeriesMember& member) {
  if (!member.label) return member.color;
  if (member.label->color) return member.label->color;
  return packed(label_color(member.label->value));
}

std::string color_text(std::uint32_t color) {
  char text[8];
  std::snprintf(text, sizeof text, "#%06x", static_cast<unsigned>(color & kWhite));
  return text;
}

std::optional<std::uint32_t> color_from(std::string_view text) {
  if (text.size() != 7 || text[0] != '#') return std::nullopt;
  return parse_number<std::uint32_t>(text.substr(1), 16);
}

}  // namespace multitetra
