#include "tests/bench/flying_edges.hpp"

#ifdef MULTITETRA_HAS_VTK

#include <vtkCellArray.h>
#include <vtkCellArrayIterator.h>
#include <vtkFlyingEdges3D.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkSMPTools.h>
#include <vtkSmartPointer.h>
#include <vtkTypeFloat32Array.h>
#include <vtkTypeInt16Array.h>
#include <vtkTypeInt8Array.h>
#include <vtkTypeUInt16Array.h>
#include <vtkTypeUInt8Array.h>
#include <vtkVersion.h>

namespace multitetra {
namespace {

// VTK's arrays of the same types.
template <typename Sample>
struct ArrayOf;
template <>
struct ArrayOf<std::uint8_t> {
  using Type = vtkTypeUInt8Array;
};
template <>
struct ArrayOf<std::int8_t> {
  using Type = vtkTypeInt8Array;
};
template <>
struct ArrayOf<std::uint16_t> {
  using Type = vtkTypeUInt16Array;
};
template <>
struct ArrayOf<std::int16_t> {
  using Type = vtkTypeInt16Array;
};
template <>
struct ArrayOf<float> {
  using Type = vtkTypeFloat32Array;
};

// Wraps the samples without a copy. VTK takes a non-const pointer but does not write through it.
template <typename Sample>
vtkSmartPointer<vtkDataArray> array_over(const Sample* samples, vtkIdType count) {
  const auto array = vtkSmartPointer<typename ArrayOf<Sample>::Type>::New();
  constexpr int kKeptByCaller = 1;
  array->SetArray(const_cast<Sample*>(samples), count, kKeptByCaller);
  return array;
}

}  // namespace

struct FlyingEdges::Image {
  vtkNew<vtkImageData> data;
};

bool FlyingEdges::is_available() { return true; }

std::string FlyingEdges::version() { return std::string("VTK ") + vtkVersion::GetVTKVersion(); }

FlyingEdges::FlyingEdges(const std::array<std::int32_t, 3>& dims,
                         const std::array<double, 3>& spacing, SamplePointer samples) {
  auto image = std::make_unique<Image>();
  image->data->SetDimensions(dims.data());
  image->data->SetSpacing(spacing.data());
  const vtkIdType count = image->data->GetNumberOfPoints();
  image->data->GetPointData()->SetScalars(
      std::visit([&](auto pointer) { return array_over(pointer, count); }, samples));
  image_ = std::move(image);
}

FlyingEdges::~FlyingEdges() = default;

FlyingEdges::Surface FlyingEdges::extract(double isovalue, int threads) const {
  Surface surface;
  vtkSMPTools::Config config;
  config.MaxNumberOfThreads = threads;
  config.Backend = threads == 1 ? "Sequential" : "TBB";
  vtkSMPTools::LocalScope(config, [&] {
    surface.backend = vtkSMPTools::GetBackend();
    surface.threads = vtkSMPTools::GetEstimatedNumberOfThreads();
    vtkNew<vtkFlyingEdges3D> filter;
    filter->SetInputData(image_->data);
    filter->SetValue(0, isovalue);
    filter->ComputeNormalsOff();
    filter->ComputeGradientsOff();
    filter->ComputeScalarsOff();
    filter->Update();
    const auto mesh = std::make_shared<const vtkSmartPointer<vtkPolyData>>(filter->GetOutput());
    surface.triangles = static_cast<std::uint64_t>((*mesh)->GetNumberOfPolys());
    surface.mesh = mesh;
  });
  return surface;
}

PlainMesh FlyingEdges::mesh_of(const Surface& surface) {
  auto* const mesh =
      static_cast<const vtkSmartPointer<vtkPolyData>*>(surface.mesh.get())->GetPointer();
  PlainMesh copy;
  for (vtkIdType i = 0; i < mesh->GetNumberOfPoints(); ++i) {
    const double* const p = mesh->GetPoint(i);
    copy.positions.push_back(
        {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])});
  }
  const auto iterator = vtk::TakeSmartPointer(mesh->GetPolys()->NewIterator());
  for (iterator->GoToFirstCell(); !iterator->IsDoneWithTraversal(); iterator->GoToNextCell()) {
    vtkIdType count = 0;
    const vtkIdType* corners = nullptr;
    iterator->GetCurrentCell(count, corners);
    copy.triangles.push_back({static_cast<std::uint32_t>(corners[0]),
                              static_cast<std::uint32_t>(corners[1]),
                              static_cast<std::uint32_t>(corners[2])});
  }
  return copy;
}

}  // namespace multitetra

#else

#include <stdexcept>

namespace multitetra {

struct FlyingEdges::Image {};

bool FlyingEdges::is_available() { return false; }

std::string FlyingEdges::version() { return "no VTK"; }

FlyingEdges::FlyingEdges(const std::array<std::int32_t, 3>&, const std::array<double, 3>&,
                         SamplePointer) {
  throw std::logic_error("This program was built without VTK.");
}

FlyingEdges::~FlyingEdges() = default;

FlyingEdges::Surface FlyingEdges::extract(double, int) const { return {}; }

PlainMesh FlyingEdges::mesh_of(const Surface&) { return {}; }

}  // namespace multitetra

#endif
