// Parses queries for thumbnails. Pure.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "server/routes/detail/query_parsers.hpp"

namespace multitetra {

struct ThumbnailQuery {
  std::optional<double> isovalue = {};  // None: the dataset's first suggestion.
  std::string up = "z";
};

[[nodiscard]] std::span<const QueryField<ThumbnailQuery>> thumbnail_fields();

// Returns kInvalidArgument, naming the parameter, if one is unknown, repeated or invalid.
[[nodiscard]] Result<ThumbnailQuery> parse_thumbnail_query(
    const std::vector<std::pair<std::string, std::string>>& query);

}  // namespace multitetra
