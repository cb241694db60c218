// The path of an HTTP request from bytes to a parsed query: requests do not depend on how the bytes
// are split, and their values are within bounds.
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "server/http/conditions.hpp"
#include "server/http/http_request.hpp"
#include "server/http/media.hpp"
#include "server/http/origin.hpp"
#include "server/http/target.hpp"
#include "server/routes/detail/mesh_query.hpp"
#include "server/routes/detail/slice_query.hpp"
#include "server/routes/path_pattern.hpp"
#include "tests/fuzz/require.hpp"

namespace multitetra {
namespace {

constexpr std::uint32_t kLimit = 4096;

// Returns the targets of the requests before a rejection, which may come earlier or later: in small
// portions a header is only parsed again when its end has arrived.
std::vector<std::string> read_in_portions(std::string_view bytes, std::size_t portion) {
  RequestReader reader(kLimit);
  std::vector<std::string> read;
  while (!bytes.empty()) {
    const std::string_view now = bytes.substr(0, portion);
    reader.feed(now);
    bytes.remove_prefix(now.size());
    for (;;) {
      auto request = reader.next();
      if (!request) return read;
      if (!*request) break;
      read.emplace_back(view_of((*request)->target()));
    }
    require(reader.rest().size() <= kLimit + portion);
  }
  return read;
}

void follow(const HttpRequest& request) {
  static_cast<void>(accepted_format(field(request, http::field::accept)));
  static_cast<void>(is_allowed_origin(field(request, http::field::origin),
                                      field(request, http::field::host), {"https://a.example"}));
  static_cast<void>(matches_tag(field(request, http::field::if_none_match), "\"1\""));
  const RangeOutcome outcome = range_of(field(request, http::field::range),
                                        field(request, http::field::if_range), "\"1\"", 1000);
  if (const auto* range = std::get_if<ByteRange>(&outcome)) {
    require(range->length > 0 && range->first < 1000 && range->length <= 1000 - range->first);
  }
  const auto target = parse_target(view_of(request.target()));
  if (!target) return;
  static_cast<void>(PathPattern("/v1/datasets/{name}/slice").match(target->path));
  static_cast<void>(path_with_token(*target));
  DatasetInfo info;
  info.name = "a";
  info.dims = {9, 10, 11};
  info.suggested_isovalues = {1};
  if (const auto slice = parse_slice_query(target->query)) {
    if (const auto plane = slice_for(slice->slice, info)) require(validated(*plane).has_value());
    const auto scale = scale_for(*slice, info);
    require(!scale || !scale->is_logarithmic || scale->low > 0);
  }
  if (const auto probe = parse_probe_query(target->query)) require(validated(*probe).has_value());
  const auto query = parse_mesh_query(target->query);
  if (!query) return;
  if (const auto surfaces = requests_for(query->surface, info)) {
    for (const IsosurfaceRequest& one : *surfaces) require(validated(one).has_value());
  }
  static_cast<void>(scalars_for(query->surface));
}

}  // namespace
}  // namespace multitetra

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace multitetra;
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  RequestReader reader(kLimit);
  reader.feed(bytes);
  for (auto request = reader.next(); request && *request; request = reader.next()) {
    follow(**request);
  }
  if (size <= 512) require(read_in_portions(bytes, 1) == read_in_portions(bytes, 7));
  return 0;
}
