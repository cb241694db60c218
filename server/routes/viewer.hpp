// Answers requests for viewer files.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "server/http/answer.hpp"
#include "server/routes/viewer_files.hpp"

namespace multitetra {

// Returns a file, or an explanatory page for "/" without a viewer; otherwise 404. Pages of the
// server and of allowed origins may frame it; "*" does not count.
[[nodiscard]] Answer viewer_answer(const ViewerFiles& files, std::string_view path,
                                   const HttpRequest& request,
                                   const std::vector<std::string>& allowed_origins,
                                   std::string_view request_id);

}  // namespace multitetra
