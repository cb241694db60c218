// Converts isosurface requests, including their thresholds, to and from protobuf.
#pragma once

#include "common/request/isosurface_request.hpp"
#include "common/wire/detail/wire_checks.hpp"
#include "multitetra/v1/request.pb.h"

namespace multitetra::wire {

void write_request(const IsosurfaceRequest& request, v1::IsosurfaceRequest& wire);
[[nodiscard]] IsosurfaceRequest read_request(const v1::IsosurfaceRequest& wire,
                                             FieldChecks& checks);

}  // namespace multitetra::wire
