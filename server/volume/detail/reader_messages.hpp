// What a sandboxed reader of a volume sends. Nothing of it is trusted: a hostile file may have
// taken over the reader.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "server/volume/formats/volume_contents.hpp"
#include "server/volume/volume_source.hpp"

namespace multitetra {

[[nodiscard]] std::string header_text(const VolumeHeader& header);
// Returns a header with all values in their ranges; nullopt for all other bytes.
[[nodiscard]] std::optional<VolumeHeader> header_from(std::string_view bytes);

[[nodiscard]] std::string contents_text(const VolumeContents& contents);
// Returns contents as documented: times for each of them, labels of their own values, all names
// valid; nullopt for all other bytes.
[[nodiscard]] std::optional<VolumeContents> contents_from(std::string_view bytes);

}  // namespace multitetra
