#include "server/programs/vertex_colors.hpp"

#include <iostream>
#include <stdexcept>

#include "common/base/exit_codes.hpp"
#include "common/base/json.hpp"
#include "common/request/painted_mesh.hpp"
#include "common/request/request_notices.hpp"
#include "common/wire/scalar_codes.hpp"
#include "server/core/sampling/vertex_scalars.hpp"

namespace multitetra {

VertexColors::VertexColors(const SurfaceArguments& arguments) : arguments_(arguments) {
  auto request = scalars_for(arguments.query);
  if (!request) throw std::invalid_argument(request.error().text);
  request_ = *std::move(request);
  if (request_) field_ = open_dataset(request_->dataset);
}

void VertexColors::add_scalars(LatticeMesh& mesh, const DatasetInfo& surface, Notices& notices,
                               bool quiet) const {
  if (!request_) return;
  if (const auto fits = check_same_world(*request_, surface, field_->info); !fits) {
    throw ExitError(kUsage, fits.error().text);
  }
  const ScalarRange range = range_for(*request_, field_->info);
  const VertexScalars found = vertex_scalars(*field_, mesh, grid_to_world(surface));
  if (field_->check) field_->check();
  const std::string codes = encode_scalars(mesh.vertices, found.values, range);
  mesh.scalars = decode_scalars(codes, mesh.vertices, range).value();
  notices.add(missing_values_notice(mesh.scalars, field_->info.name));
  if (!quiet) std::cerr << color_accuracy_text(range, found.largest_deviation) << std::endl;
}

void VertexColors::paint(PositionedMesh& mesh) const {
  if (request_)
    multitetra::paint(mesh, range_for(*request_, field_->info), arguments_.query.colors);
}

void VertexColors::describe(Json& report) const {
  if (!request_) return;
  const ScalarRange range = range_for(*request_, field_->info);
  report["color_by"] = field_->info.name;
  report["color_range"] = {range.low, range.high};
}

}  // namespace multitetra
