// Compares sample shells with Draco on the same tiles: bits per vertex, and nanoseconds per vertex
// to encode and decode, on one thread (processor time, minimum of the runs).
//
//   shell_bench ../shared/data/embryo_256x256x256.vti 80.5 --runs 5 --lattice 5
//
// Tiles have 64 cells per side. Shells are encoded from samples, including the computation of
// signs, and decoded to triangles; Draco encodes and decodes the triangles, without checks or
// welding. Exact shells are measured for integers only, lattice-exact and quantized shells for all
// types.

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <exception>
#include <functional>
#include <iostream>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

#include <draco/compression/decode.h>
#include <draco/mesh/mesh.h>

#include "common/codec/shell_decoder.hpp"
#include "common/codec/shell_encoder.hpp"
#include "common/sandbox/sandbox.hpp"
#include "common/wire/tile.hpp"
#include "server/volume/volume_files.hpp"

namespace multitetra {
namespace {

constexpr int kCells = 64;

double thread_seconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double least_seconds(int runs, const std::function<void()>& work) {
  double least = std::numeric_limits<double>::infinity();
  for (int run = 0; run < runs; ++run) {
    const double start = thread_seconds();
    work();
    least = std::min(least, thread_seconds() - start);
  }
  return least;
}

struct Totals {
  double bytes = 0;
  double encode_seconds = 0;
  double decode_seconds = 0;
};

struct Measured {
  std::string name;
  shell::ShellOptions options;
  Totals totals = {};
};

class ShellBench {
 public:
  ShellBench(const Volume& volume, double isovalue, int runs, int lattice_resolution)
      : volume_(volume), runs_(runs) {
    const auto add = [&](std::string name, shell::ShellValues values, int levels) {
      shells_.push_back({.name = std::move(name),
                         .options = {.isovalue = isovalue,
                                     .values = values,
                                     .levels_per_octave = levels,
                                     .lattice_resolution = lattice_resolution}});
    };
    if (volume.type() != SampleType::kF32) add("exact", shell::ShellValues::kExact, 8);
    add("lattice-exact", shell::ShellValues::kLatticeExact, 8);
    for (const int levels : {8, 4, 2, 1}) {
      add("L = " + std::to_string(levels), shell::ShellValues::kQuantized, levels);
    }
  }

  void run() {
    const auto& dims = volume_.dims;
    for (int z = 0; z + 1 < dims[2]; z += kCells) {
      for (int y = 0; y + 1 < dims[1]; y += kCells) {
        for (int x = 0; x + 1 < dims[0]; x += kCells) measure_tile({x, y, z});
      }
    }
  }

  void print() const {
    std::printf("%zu vertices, %zu triangles\n", vertices_, triangles_);
    std::printf("%-14s %10s %8s %10s %10s\n", "", "KiB", "bits", "encode ns", "decode ns");
    for (const Measured& shell : shells_) print(shell.name, shell.totals);
    print("Draco", draco_);
  }

 private:
  void measure_tile(const std::array<std::int32_t, 3>& low) {
    shell::ShellBox box{.samples = {}, .data_samples = {}, .origin = low};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      box.data_samples[axis] = std::min(kCells + 1, volume_.dims[axis] - low[axis]);
    }
    std::visit(
        [&](const auto& samples) {
          using Sample = typename std::decay_t<decltype(samples)>::value_type;
          box.samples = shell::SampleBlock<Sample>{
              .first = samples.data() + volume_.index(low[0], low[1], low[2]),
              .row = volume_.dims[0],
              .slice = std::ptrdiff_t{volume_.dims[0]} * volume_.dims[1]};
        },
        volume_.samples);
    for (std::size_t i = 0; i < shells_.size(); ++i) {
      if (!measure_shell(box, shells_[i])) return;
      if (i == 0) {
        vertices_ += mesh_vertices_.size();
        triangles_ += mesh_triangles_.size();
        measure_draco();
      }
    }
  }

  // Returns false for a tile without surface.
  bool measure_shell(const shell::ShellBox& box, Measured& shell) {
    std::vector<std::uint8_t> bytes;
    const double encode_seconds =
        least_seconds(runs_, [&] { bytes = encoder_.encode(box, shell.options).value(); });
    shell::ShellHeader header;
    if (read_shell_header(bytes.data(), bytes.size(), header) != shell::ShellStatus::kOk) {
      throw std::logic_error("A shell's header cannot be read");
    }
    if (header.triangles == 0) return false;
    mesh_vertices_.resize(header.vertices);
    mesh_triangles_.resize(header.triangles);
    shell.totals.decode_seconds += least_seconds(runs_, [&] {
      if (decoder_->decode(bytes.data(), bytes.size(), mesh_vertices_.data(),
                           mesh_triangles_.data()) != shell::ShellStatus::kOk) {
        throw std::logic_error("A shell cannot be decoded");
      }
    });
    shell.totals.encode_seconds += encode_seconds;
    shell.totals.bytes += static_cast<double>(bytes.size());
    return true;
  }

  void measure_draco() {
    LatticeMesh mesh;
    for (const shell::ShellVertex& v : mesh_vertices_) mesh.vertices.push_back({v.x, v.y, v.z});
    for (const shell::ShellTriangle& t : mesh_triangles_) {
      mesh.triangles.push_back({t.corners[0], t.corners[1], t.corners[2]});
    }
    const OctreeCube cube = {.exponent = 15};
    const ContentDigest content = digest(mesh);
    EncodedTile encoded;
    draco_.encode_seconds +=
        least_seconds(runs_, [&] { encoded = encode_tile(mesh, cube, content); });
    draco_.decode_seconds += least_seconds(runs_, [&] {
      draco::DecoderBuffer buffer;
      buffer.Init(encoded.payload->data(), encoded.payload->size());
      draco::Decoder decoder;
      if (!decoder.DecodeMeshFromBuffer(&buffer).ok()) {
        throw std::logic_error("Draco cannot decode its own bytes");
      }
    });
    draco_.bytes += static_cast<double>(encoded.payload->size());
  }

  void print(const std::string& name, const Totals& totals) const {
    const auto vertices = static_cast<double>(vertices_);
    std::printf("%-14s %10.1f %8.3f %10.1f %10.1f\n", name.c_str(), totals.bytes / 1024,
                8 * totals.bytes / vertices, 1e9 * totals.encode_seconds / vertices,
                1e9 * totals.decode_seconds / vertices);
  }

  const Volume& volume_;
  int runs_;
  std::vector<Measured> shells_;
  Totals draco_;
  std::size_t vertices_ = 0;
  std::size_t triangles_ = 0;
  shell::ShellEncoder encoder_;
  std::unique_ptr<shell::ShellDecoder> decoder_ = std::make_unique<shell::ShellDecoder>();
  std::vector<shell::ShellVertex> mesh_vertices_;
  std::vector<shell::ShellTriangle> mesh_triangles_;
};

int run(int count, char** arguments) {
  int runs = 5;
  int lattice_resolution = kDefaultLatticeResolution;
  bool is_understood = count >= 3 && count % 2 == 1;
  for (int i = 3; is_understood && i < count; i += 2) {
    const std::string_view option = arguments[i];
    is_understood = option == "--runs" || option == "--lattice";
    (option == "--runs" ? runs : lattice_resolution) = std::stoi(arguments[i + 1]);
  }
  if (!is_understood) {
    std::cerr << "Usage: shell_bench VOLUME ISOVALUE [--runs N] [--lattice R]\n";
    return 2;
  }
  const Volume volume = read_volume(arguments[1]);
  ShellBench bench(volume, std::stod(arguments[2]), runs, lattice_resolution);
  bench.run();
  bench.print();
  return 0;
}

}  // namespace
}  // namespace multitetra

int main(int count, char** arguments) {
  multitetra::enter_sandbox_if_asked(count, arguments);
  try {
    return multitetra::run(count, arguments);
  } catch (const std::exception& failure) {
    std::cerr << failure.what() << "\n";
    return 1;
  }
}
