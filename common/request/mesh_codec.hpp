// The compression of meshes in GLB files.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "common/base/enum_names.hpp"
#include "common/base/result.hpp"

namespace multitetra {

enum class MeshCodec {
  kNone,
  kMeshopt,  // EXT_meshopt_compression.
};

inline constexpr EnumNames<MeshCodec, 2> kMeshCodecs = {{"none", "meshopt"}};

[[nodiscard]] inline std::string_view name(MeshCodec codec) { return kMeshCodecs.of(codec); }
[[nodiscard]] inline std::optional<MeshCodec> mesh_codec_from(std::string_view name) {
  return kMeshCodecs.find(name);
}

// Fails with kInvalidArgument for a codec that files other than GLB lack.
[[nodiscard]] inline Result<void> check_codec(MeshCodec codec, bool is_glb) {
  if (codec == MeshCodec::kNone || is_glb) return {};
  return fail(ErrorCode::kInvalidArgument,
              "codec: " + std::string(name(codec)) + " compresses GLB files alone.");
}

}  // namespace multitetra
