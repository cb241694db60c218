// The web viewer, or a page that lists the resources if it is not installed.

#include <string>
#include <utility>
#include <vector>

#include "server/routes/resource.hpp"

namespace multitetra {
namespace {

// The page may connect to its own host only, so no link can make it send data, such as a token,
// elsewhere. 'self' includes WebSockets of that host in every browser that supports the page's
// style.
constexpr std::string_view kPolicy =
    "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self'; "
    "connect-src 'self'; img-src 'self' blob: data:; "
    "style-src 'self' 'unsafe-inline'; object-src 'none'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'self'";  // Further origins are appended here.

constexpr std::string_view kPage =
    "<!doctype html>\n"
    "<html lang=\"en\"><head><meta charset=\"utf-8\"><title>Multi-Tetra streaming</title>\n"
    "<meta name=\"viewport\" content=\"width=device-width\">\n"
    "<style>body{font:1rem/1.5 sans-serif;max-width:40rem;margin:3rem auto;padding:0 "
    "1rem}</style></head><body>\n"
    "<h1>Multi-Tetra streaming</h1>\n"
    "<p>This server offers isosurfaces of volume data. Its web viewer is not installed. Available "
    "resources:</p>\n"
    "<ul><li><a href=\"v1/datasets\">v1/datasets</a>: the datasets</li>\n"
    "<li>v1/datasets/NAME/isosurface?isovalue=V&amp;error=1&amp;format=glb: a mesh</li>\n"
    "<li>v1/stream: the conversation over a WebSocket (multitetra.v1)</li>\n"
    "<li><a href=\"v1/openapi.json\">v1/openapi.json</a>: all resources in detail</li></ul>\n"
    "</body></html>\n";

bool accepts(const HttpRequest& request, std::string_view coding) {
  std::string_view accepted = field(request, http::field::accept_encoding);
  const std::size_t at = accepted.find(coding);
  if (at == std::string_view::npos) return false;
  accepted.remove_prefix(at + coding.size());
  return !accepted.starts_with(";q=0,") && accepted != ";q=0";
}

// Allowed origins may also frame the page. "*" does not apply to frames: an unknown page could
// overlay the viewer and read its content.
void add_security_headers(HttpResponse& response, const std::vector<std::string>& allowed_origins) {
  std::string policy(kPolicy);
  for (const std::string& origin : allowed_origins) {
    if (origin != "*") policy += ' ' + origin;
  }
  add_field(response, "Content-Security-Policy", policy);
  add_field(response, "X-Content-Type-Options", "nosniff");
}

HttpResponse viewer_answer(const ResourceContext& context, const ResourceRequest& of) {
  const ViewerFiles& files = *context.options.viewer;
  const std::string_view path = of.target.raw_path;
  HttpResponse response;
  const ViewerFileContent* const file = files.find(path);
  if (!file && (path != "/" || !files.is_empty())) {
    return error_answer(
        404,
        {ErrorCode::kInvalidArgument, "There is no resource \"" + std::string(path) +
                                          "\"; /v1/openapi.json lists all resources."},
        of.context.request_id);
  }
  add_security_headers(response, context.http.allowed_origins);
  if (!file) {
    add_field(response, "Content-Type", "text/html; charset=utf-8");
    add_field(response, "Cache-Control", "no-cache");
    response.body = body_of(std::string(kPage));
    return response;
  }
  std::string tag = file->tag;
  SharedBytes bytes = file->bytes;
  if (file->gzip || file->brotli) add_field(response, "Vary", "Accept-Encoding");
  for (const auto& [coding, coded] : {std::pair("br", file->brotli), {"gzip", file->gzip}}) {
    if (!coded || !accepts(of.http, coding)) continue;
    add_field(response, "Content-Encoding", coding);
    tag.insert(tag.size() - 1, std::string("-") + coding);
    bytes = coded;
    break;
  }
  add_field(response, "Content-Type", file->type);
  add_field(response, "Cache-Control",
            file->is_named_by_content ? "public, max-age=31536000, immutable" : "no-cache");
  response.body = body_of(std::move(bytes));
  response.body.is_resident = true;
  apply_conditions(response, of.http, tag);
  return response;
}

}  // namespace

Resource viewer_resource(const ResourceContext& context) {
  return {.name = "viewer",
          .path = "/{path...}",
          .kind = Resource::Kind::kFree,
          .answer = [&context](ResourceRequest request) -> asio::awaitable<HttpResponse> {
            co_return viewer_answer(context, request);
          }};
}

}  // namespace multitetra
