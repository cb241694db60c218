#include "server/http/media.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <string>
#include <utility>

#include "common/base/parse_number.hpp"
#include "common/base/text.hpp"

namespace multitetra {
namespace {

bool equal_words(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](unsigned char x, unsigned char y) {
    return std::tolower(x) == std::tolower(y);
  });
}

// Returns how specifically a media range matches a type: 2 exact, 1 "model/*", 0 "*/*", -1 no
// match.
int specificity(std::string_view range, std::string_view type) {
  if (equal_words(range, type)) return 2;
  if (range == "*/*") return 0;
  const std::string_view family = type.substr(0, type.find('/') + 1);
  return range.ends_with("/*") && equal_words(range.substr(0, range.size() - 1), family) ? 1 : -1;
}

double weight_of(std::string_view parameters) {
  for (std::size_t at = 0; at != std::string_view::npos;) {
    const std::size_t end = parameters.find(';', at);
    const std::string_view one =
        trimmed(parameters.substr(at, end == std::string_view::npos ? end : end - at));
    if (one.starts_with("q=") || one.starts_with("Q=")) {
      std::string_view digits = std::string_view(one).substr(2);
      const double weight = take_number<double>(digits).value_or(0);
      return weight >= 0 && weight <= 1 ? weight : 0;
    }
    at = end == std::string_view::npos ? end : end + 1;
  }
  return 1;
}

// Returns the quality of the most specific range that matches the type.
double quality_of(std::string_view accept, std::string_view type) {
  int best = -1;
  double weight = 0;
  for (const std::string_view one : split(accept, ',')) {
    const std::size_t semicolon = one.find(';');
    const int exact = specificity(trimmed(one.substr(0, semicolon)), type);
    if (exact > best) {
      best = exact;
      weight = semicolon == std::string_view::npos ? 1 : weight_of(one.substr(semicolon + 1));
    }
  }
  return weight;
}

constexpr std::array<std::pair<std::string_view, std::string_view>, 17> kTypes = {
    {{".css", "text/css; charset=utf-8"},
     {".glb", "model/gltf-binary"},
     {".html", "text/html; charset=utf-8"},
     {".ico", "image/x-icon"},
     {".jpg", "image/jpeg"},
     {".js", "text/javascript; charset=utf-8"},
     {".json", "application/json"},
     {".map", "application/json"},
     {".md", "text/markdown; charset=utf-8"},
     {".mjs", "text/javascript; charset=utf-8"},
     {".png", "image/png"},
     {".svg", "image/svg+xml"},
     {".txt", "text/plain; charset=utf-8"},
     {".wasm", "application/wasm"},
     {".webmanifest", "application/manifest+json"},
     {".webp", "image/webp"},
     {".woff2", "font/woff2"}}};

}  // namespace

std::string_view media_type_of_file(std::string_view name) {
  for (const auto& [suffix, type] : kTypes) {
    if (name.ends_with(suffix)) return type;
  }
  return "application/octet-stream";
}

std::optional<MeshFormat> accepted_format(std::string_view accept) {
  if (trimmed(accept).empty()) return MeshFormat::kGlb;
  std::optional<MeshFormat> best;
  double best_weight = 0;
  for (const MeshFormat format :
       {MeshFormat::kGlb, MeshFormat::kPly, MeshFormat::kStl, MeshFormat::kObj, MeshFormat::kDrc,
        MeshFormat::kVtp, MeshFormat::k3mf}) {
    const double weight = quality_of(accept, media_type(format));
    if (weight > best_weight) {
      best = format;
      best_weight = weight;
    }
  }
  return best;
}

}  // namespace multitetra
