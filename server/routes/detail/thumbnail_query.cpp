#include "server/routes/detail/thumbnail_query.hpp"

#include "common/base/parse_number.hpp"
#include "common/picture/camera.hpp"
#include "common/request/field_setters.hpp"

namespace multitetra {
namespace {

using Q = ThumbnailQuery;

std::optional<double> finite_from(std::string_view text) { return parse_finite(text); }

FieldError set_up(const QueryField<Q>& field, std::string_view text, Q& query) {
  if (!up_axis_from(text)) return "must be " + alternatives(field.value_syntax);
  query.up = text;
  return std::nullopt;
}

constexpr QueryField<Q> kFields[] = {
    {"isovalue", "a finite number", "", "The isovalue; default: the dataset's suggestion",
     set_word<&Q::isovalue, finite_from>},
    {"up", "x|-x|y|-y|z|-z", "z", "The world axis that points up", set_up}};

}  // namespace

std::span<const QueryField<ThumbnailQuery>> thumbnail_fields() { return kFields; }

Result<ThumbnailQuery> parse_thumbnail_query(
    const std::vector<std::pair<std::string, std::string>>& query) {
  return parse_query<ThumbnailQuery>(query, thumbnail_fields());
}

}  // namespace multitetra
