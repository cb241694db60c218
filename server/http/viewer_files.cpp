#include "server/http/viewer_files.hpp"

#include <array>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <span>
#include <stdexcept>

#include "server/dataset/checksum.hpp"
#include "server/http/media.hpp"

namespace multitetra {
namespace {

// The page talks with the host it came from and with no other: whatever an address tells it,
// nothing that it knows, a token least of all, goes elsewhere. 'self' takes in WebSockets of that
// host, in every browser that knows the colours of the page's style.
constexpr std::string_view kPolicy =
    "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self'; "
    "connect-src 'self'; img-src 'self' blob: data:; "
    "style-src 'self' 'unsafe-inline'; object-src 'none'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'self'";

constexpr std::string_view kPage =
    "<!doctype html>\n"
    "<html lang=\"en\"><head><meta charset=\"utf-8\"><title>Multi-Tetra streaming</title>\n"
    "<meta name=\"viewport\" content=\"width=device-width\">\n"
    "<style>body{font:1rem/1.5 sans-serif;max-width:40rem;margin:3rem auto;padding:0 1rem}"
    "</style></head><body>\n"
    "<h1>Multi-Tetra streaming</h1>\n"
    "<p>This server offers isosurfaces of volume data. Its web viewer is not installed here; "
    "what there is:</p>\n"
    "<ul><li><a href=\"v1/datasets\">v1/datasets</a>: the datasets</li>\n"
    "<li>v1/datasets/NAME/isosurface?isovalue=V&amp;error=1&amp;format=glb: a mesh</li>\n"
    "<li>v1/stream: the conversation over a WebSocket (multitetra.v1)</li>\n"
    "<li><a href=\"v1/openapi.json\">v1/openapi.json</a>: all of it in detail</li></ul>\n"
    "</body></html>\n";

SharedBytes bytes_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw std::runtime_error("Cannot read the viewer's file '" + file.string() + "'.");
  return std::make_shared<const std::string>(std::istreambuf_iterator<char>(in),
                                             std::istreambuf_iterator<char>());
}

std::string tag_of(std::string_view bytes) {
  std::array<char, 24> text{};
  std::snprintf(text.data(), text.size(), "\"%016llx\"",
                static_cast<unsigned long long>(
                    checksum(std::as_bytes(std::span(bytes.data(), bytes.size())))));
  return text.data();
}

bool accepts(const HttpRequest& request, std::string_view coding) {
  std::string_view accepted = field(request, http::field::accept_encoding);
  const std::size_t at = accepted.find(coding);
  if (at == std::string_view::npos) return false;
  accepted.remove_prefix(at + coding.size());
  return !accepted.starts_with(";q=0,") && accepted != ";q=0";
}

void say_policy(Answer& answer) {
  add_field(answer, "Content-Security-Policy", kPolicy);
  add_field(answer, "X-Content-Type-Options", "nosniff");
}

}  // namespace

ViewerFiles::ViewerFiles(const std::filesystem::path& folder) {
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (entry.is_symlink() || !entry.is_regular_file()) continue;
    const std::string name = entry.path().lexically_relative(folder).generic_string();
    const SharedBytes bytes = bytes_of(entry.path());
    files_["/" + name] = {.bytes = bytes,
                          .gzip = nullptr,
                          .brotli = nullptr,
                          .type = media_type_of_file(name),
                          .tag = tag_of(*bytes),
                          .is_named_by_content = name.starts_with("assets/")};
  }
  for (auto& [name, file] : files_) {
    if (const auto gzip = files_.find(name + ".gz"); gzip != files_.end()) {
      file.gzip = gzip->second.bytes;
    }
    if (const auto brotli = files_.find(name + ".br"); brotli != files_.end()) {
      file.brotli = brotli->second.bytes;
    }
  }
}

const ViewerFileContent* ViewerFiles::find(std::string_view path) const {
  const auto found = files_.find(path == "/" ? std::string_view("/index.html") : path);
  return found == files_.end() ? nullptr : &found->second;
}

std::shared_ptr<const ViewerFiles> find_viewer(const std::filesystem::path& folder) {
  if (!folder.empty()) return std::make_shared<const ViewerFiles>(folder);
  std::error_code unknown;  // Without /proc nobody knows where this program is.
  const auto program = std::filesystem::read_symlink("/proc/self/exe", unknown);
  const auto own = program.parent_path().parent_path() / "share" / "multitetra" / "viewer";
  if (unknown || !std::filesystem::is_directory(own)) return std::make_shared<const ViewerFiles>();
  return std::make_shared<const ViewerFiles>(own);
}

Answer viewer_answer(const ViewerFiles& files, std::string_view path, const HttpRequest& request,
                     std::string_view request_id) {
  Answer answer;
  const ViewerFileContent* const file = files.find(path);
  if (!file && (path != "/" || !files.is_empty())) {
    return error_answer(
        404,
        {ErrorCode::kInvalidArgument, "There is nothing at \"" + std::string(path) +
                                          "\"; /v1/openapi.json tells what there is."},
        request_id);
  }
  say_policy(answer);
  if (!file) {
    add_field(answer, "Content-Type", "text/html; charset=utf-8");
    add_field(answer, "Cache-Control", "no-cache");
    answer.body = body_of(std::string(kPage));
    return answer;
  }
  std::string tag = file->tag;
  SharedBytes bytes = file->bytes;
  if (file->gzip || file->brotli) add_field(answer, "Vary", "Accept-Encoding");
  for (const auto& [coding, coded] : {std::pair("br", file->brotli), {"gzip", file->gzip}}) {
    if (!coded || !accepts(request, coding)) continue;
    add_field(answer, "Content-Encoding", coding);
    tag.insert(tag.size() - 1, std::string("-") + coding);
    bytes = coded;
    break;
  }
  add_field(answer, "Content-Type", file->type);
  add_field(answer, "Cache-Control",
            file->is_named_by_content ? "public, max-age=31536000, immutable" : "no-cache");
  answer.body = body_of(std::move(bytes));
  meet_conditions(answer, request, tag);
  return answer;
}

}  // namespace multitetra
