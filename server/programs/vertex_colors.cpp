#include "server/programs/vertex_colors.hpp"

#include <iostream>
#include <stdexcept>

#include "common/base/exit_codes.hpp"
#include "common/wire/scalar_codes.hpp"
#include "server/core/sampling/vertex_scalars.hpp"

namespace multitetra {

VertexColors::VertexColors(const SurfaceArguments& arguments) {
  auto request = scalars_for(arguments.query);
  if (!request) throw std::invalid_argument(request.error().text);
  request_ = *std::move(request);
  if (request_) field_ = open_dataset(request_->dataset);
}

std::optional<ScalarRange> VertexColors::add_scalars(LatticeMesh& mesh, const DatasetInfo& surface,
                                                     bool quiet) const {
  if (!request_) return std::nullopt;
  if (const auto fits = check_same_world(*request_, surface, field_->info); !fits) {
    throw ExitError(kUsage, fits.error().text);
  }
  const ScalarRange range = range_for(*request_, field_->info);
  const VertexScalars found = vertex_scalars(*field_, mesh, grid_to_world(surface));
  if (field_->check) field_->check();
  const std::string codes = encode_scalars(mesh.vertices, found.values, range);
  mesh.scalars = decode_scalars(codes, mesh.vertices, range).value();
  if (!quiet) std::cerr << color_accuracy_text(range, found.largest_deviation) << std::endl;
  return range;
}

}  // namespace multitetra
