// Files of the viewer as answers.
#pragma once

#include <string_view>

#include "server/http/answer.hpp"
#include "server/http/viewer_files.hpp"

namespace multitetra {

// A file, or the page for "/" where there is no viewer; 404 otherwise.
[[nodiscard]] Answer viewer_answer(const ViewerFiles& files, std::string_view path,
                                   const HttpRequest& request, std::string_view request_id);

}  // namespace multitetra
