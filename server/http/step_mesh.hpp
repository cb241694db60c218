// The mesh of a step as its tiles bring it.
#pragma once

#include <stop_token>

#include "common/base/result.hpp"
#include "common/mesh/mesh.hpp"
#include "server/http/one_shot_session.hpp"

namespace multitetra {

// Decoded and welded, with its scalars where it was asked for some. kDamagedData when a tile is
// missing or not what it should be; kCancelled soon after `stop` is triggered.
[[nodiscard]] Result<LatticeMesh> welded_mesh(const OneShotSession::Step& step,
                                              const std::stop_token& stop);

}  // namespace multitetra
