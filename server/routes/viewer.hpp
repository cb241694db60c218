// Files of the viewer as answers.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "server/http/answer.hpp"
#include "server/routes/viewer_files.hpp"

namespace multitetra {

// A file, or the page for "/" where there is no viewer; 404 otherwise. Pages of the allowed origins
// may have it in a frame, as those of the server may; "*" is none of them.
[[nodiscard]] Answer viewer_answer(const ViewerFiles& files, std::string_view path,
                                   const HttpRequest& request,
                                   const std::vector<std::string>& allowed_origins,
                                   std::string_view request_id);

}  // namespace multitetra
