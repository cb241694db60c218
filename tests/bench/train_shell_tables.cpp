// Generates common/codec/detail/trained_tables.hpp, initial probabilities of the shell coder.
//
//   train_shell_tables weights volumes.txt > new.hpp         then compile with new.hpp in its place
//   train_shell_tables probabilities volumes.txt > new.hpp   and again
//
// A line of volumes.txt is "file type nx ny nz isovalue..."; the file has only samples, little
// endian, x fastest, and the type is u8, u16, i16 or f32. Integers train exact shells, and like
// floats also levels. Volumes measured by benchmarks are excluded. The tables were trained on these
// public volumes: cthead (8 and 16 bits), engine, bonsai_small, Iguana, chris_t1, avg152T1, tooth
// (8 and 16 bits), headsq, stent, Brain_float, fuel, neghip and viscousfingers.
//
// Weights: least squares over the active samples of all volumes, one set for each of the 128
// combinations of active neighbors, regularized towards a common set. Probabilities: the frequency
// of 1 bits per context, with equal weight for all volumes.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <iostream>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "common/codec/detail/corrections.hpp"
#include "common/codec/detail/crossed_edges.hpp"
#include "common/codec/detail/level_of_distance.hpp"
#include "common/codec/detail/level_scale.hpp"
#include "common/codec/detail/magnitude_coder.hpp"
#include "common/codec/detail/marching.hpp"
#include "common/codec/detail/row_bits.hpp"
#include "common/codec/detail/shell_model.hpp"
#include "common/codec/detail/sign_coder.hpp"

namespace multitetra::shell {
namespace {

struct TrainingVolume {
  std::string file;
  bool is_integer = true;
  std::array<int, 3> size{};
  std::vector<double> isovalues;
  std::vector<float> samples;
};

template <typename Sample>
std::vector<float> read_samples(const std::string& file, std::size_t count) {
  std::vector<Sample> read(count);
  std::ifstream in(file, std::ios::binary);
  in.read(reinterpret_cast<char*>(read.data()),
          static_cast<std::streamsize>(count * sizeof(Sample)));
  if (!in) throw std::runtime_error(file + " is too short");
  return {read.begin(), read.end()};
}

std::vector<TrainingVolume> read_volumes(const std::string& list) {
  std::vector<TrainingVolume> volumes;
  std::ifstream in(list);
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    TrainingVolume volume;
    std::string type;
    words >> volume.file >> type >> volume.size[0] >> volume.size[1] >> volume.size[2];
    for (double isovalue = 0; words >> isovalue;) volume.isovalues.push_back(isovalue);
    const auto count = static_cast<std::size_t>(volume.size[0]) *
                       static_cast<std::size_t>(volume.size[1]) *
                       static_cast<std::size_t>(volume.size[2]);
    volume.is_integer = type != "f32";
    volume.samples = type == "u8"    ? read_samples<std::uint8_t>(volume.file, count)
                     : type == "u16" ? read_samples<std::uint16_t>(volume.file, count)
                     : type == "i16" ? read_samples<std::int16_t>(volume.file, count)
                                     : read_samples<float>(volume.file, count);
    volumes.push_back(std::move(volume));
  }
  return volumes;
}

// A box of a volume with its signs and the values to code.
struct Tile {
  const TrainingVolume* volume = nullptr;
  double isovalue = 0;
  std::array<int, 3> low{};
  std::array<int, 3> size{};

  [[nodiscard]] float at(int x, int y, int z) const {
    const auto& n = volume->size;
    return volume
        ->samples[static_cast<std::size_t>(low[0] + x) +
                  static_cast<std::size_t>(n[0]) *
                      (static_cast<std::size_t>(low[1] + y) +
                       static_cast<std::size_t>(n[1]) * static_cast<std::size_t>(low[2] + z))];
  }
};

void for_each_tile(const TrainingVolume& volume, double isovalue,
                   const std::function<void(const Tile&)>& visit) {
  constexpr int kCells = 64;
  std::array<int, 3> low{};
  for (low[2] = 0; low[2] + 1 < volume.size[2]; low[2] += kCells) {
    for (low[1] = 0; low[1] + 1 < volume.size[1]; low[1] += kCells) {
      for (low[0] = 0; low[0] + 1 < volume.size[0]; low[0] += kCells) {
        Tile tile{.volume = &volume, .isovalue = isovalue, .low = low, .size = {}};
        for (std::size_t axis = 0; axis < 3; ++axis) {
          tile.size[axis] = std::min(kCells + 1, volume.size[axis] - low[axis]);
        }
        visit(tile);
      }
    }
  }
}

// Counts of 0 and 1 bits for each probability of a model.
template <typename Model>
struct Counts {
  static constexpr std::size_t kSize = sizeof(Model) / sizeof(Probability);
  std::vector<std::array<double, 2>> of = std::vector<std::array<double, 2>>(kSize);

  // Adds another count, scaled to a total of 1e7.
  void add(const Counts& other) {
    double total = 0;
    for (const auto& [zeros, ones] : other.of) total += zeros + ones;
    if (total == 0) return;
    for (std::size_t i = 0; i < kSize; ++i) {
      for (std::size_t bit = 0; bit < 2; ++bit) of[i][bit] += other.of[i][bit] * 1e7 / total;
    }
  }
  [[nodiscard]] std::vector<int> probabilities() const {
    std::vector<int> result;
    for (const auto& [zeros, ones] : of) {
      const double p = (ones + 0.4) / (zeros + ones + 0.8);
      result.push_back(std::clamp(static_cast<int>(p * 256), 0, 255));
    }
    return result;
  }
};

// Replaces the range coder.
template <typename Model>
class CountingCoder {
 public:
  static constexpr bool kEncodes = true;
  CountingCoder(const Model& model, Counts<Model>& counts) : model_(model), counts_(counts) {}

  bool bit(Probability& p, bool one) {
    const auto index = &p - reinterpret_cast<const Probability*>(&model_);
    counts_.of[static_cast<std::size_t>(index)][one ? 1 : 0] += 1;
    return one;
  }
  std::uint32_t raw_bits(int, std::uint32_t bits) { return bits; }

 private:
  const Model& model_;
  Counts<Model>& counts_;
};

// Least squares in eleven unknowns, regularized towards known values.
struct Equations {
  std::array<std::array<double, kWeights + 1>, kWeights> of{};

  void add(const std::array<double, kWeights>& inputs, double output, double weight) {
    for (std::size_t i = 0; i < kWeights; ++i) {
      for (std::size_t j = 0; j < kWeights; ++j) of[i][j] += weight * inputs[i] * inputs[j];
      of[i][kWeights] += weight * inputs[i] * output;
    }
  }
  [[nodiscard]] std::array<double, kWeights> solved(
      const std::array<double, kWeights>& near) const {
    constexpr double kPull = 30;
    auto rows = of;
    for (std::size_t i = 0; i < kWeights; ++i) {
      rows[i][i] += kPull;
      rows[i][kWeights] += kPull * near[i];
    }
    for (std::size_t i = 0; i < kWeights; ++i) {  // Positive definite: no pivoting.
      for (std::size_t j = 0; j < kWeights; ++j) {
        if (i == j) continue;
        const double factor = rows[j][i] / rows[i][i];
        for (std::size_t k = i; k <= kWeights; ++k) rows[j][k] -= factor * rows[i][k];
      }
    }
    std::array<double, kWeights> result{};
    for (std::size_t i = 0; i < kWeights; ++i) result[i] = rows[i][kWeights] / rows[i][i];
    return result;
  }
};

struct Trainer {
  BitField signs;
  SignBlocks blocks;
  CrossedEdges edges;
  SampleRings rings;
  LevelScale scale;
  ShellModel model;

  bool find_signs(const Tile& tile) {
    bool low = false;
    bool high = false;
    signs.begin(tile.size[0], tile.size[1], tile.size[2]);
    for (int z = 0; z < tile.size[2]; ++z) {
      for (int y = 0; y < tile.size[1]; ++y) {
        for (int x = 0; x < tile.size[0]; ++x) {
          const bool above = static_cast<double>(tile.at(x, y, z)) > tile.isovalue;
          (above ? high : low) = true;
          if (above) signs.row(y, z) |= samples_from_to(x, x + 1);
        }
      }
    }
    signs.finish();
    return low && high;
  }

  // Visits the active samples, then the crossed edges, of all slices.
  template <typename Sample, typename Edge>
  void for_each_active(const Tile& tile, const Sample& in_row, const Edge& on_edge) {
    const std::int32_t origin[3] = {tile.low[0], tile.low[1], tile.low[2]};
    edges.begin(signs, nullptr, origin);
    rings.begin();
    for (int z = 0; z < tile.size[2]; ++z) {
      edges.find(z);
      rings.begin_slice(z, tile.size[1]);
      for (int y = 0; y < tile.size[1]; ++y) in_row(edges.active(y, z), y, z);
      const auto visit = [&](int slice, int first, int end) {
        for (int y = 0; y < tile.size[1]; ++y) {
          for (int d = first; edges.any(y, slice) && d < end; ++d) {
            for_each_sample(edges.crossed(d, y, slice), [&](int x) { on_edge(x, y, slice, d); });
          }
        }
      };
      if (z > 0) visit(z - 1, kDirectionsInSlice, kEdgeDirections);
      visit(z, 0, kDirectionsInSlice);
    }
  }

  // Requires the signs.
  template <typename Magnitudes, typename Next, typename Edge>
  void count_values(const Tile& tile, const Magnitudes& magnitudes, Counts<ValueModel>& counts,
                    const Next& next, const Edge& on_edge) {
    CountingCoder coder(model.values, counts);
    RunningMeans recent = Magnitudes::start();
    for_each_active(
        tile,
        [&](RowBits active, int y, int z) {
          RowBits rest = active;
          code_row_of_samples(
              coder, model.values, magnitudes, signs, active, y, z, rings, recent,
              [&] {
                int x = -1;
                for_each_sample(rest, [&](int at) { x = x < 0 ? at : x; });
                rest = rest & ~samples_from_to(x, x + 1);
                return next(x, y, z);
              },
              [&](int x, std::int32_t level) { rings.levels(y, z)[x] = level; });
        },
        on_edge);
  }

  void count_exact(const Tile& tile, Counts<ValueModel>& counts) {
    const auto below = static_cast<std::int32_t>(std::floor(tile.isovalue));
    count_values(
        tile, ExactMagnitudes(), counts,
        [&](int x, int y, int z) {
          const std::int32_t above = static_cast<std::int32_t>(tile.at(x, y, z)) - below;
          return above > 0 ? above - 1 : -above;
        },
        [](int, int, int, int) {});
  }

  void count_levels(const Tile& tile, int levels_per_octave, Counts<ValueModel>& counts,
                    Counts<CorrectionModel>& corrections) {
    const auto level_at = [&](int x, int y, int z) {
      const double distance = std::abs(static_cast<double>(tile.at(x, y, z)) - tile.isovalue);
      return distance > 0 ? level_of_distance(distance, levels_per_octave) : INT32_MIN;
    };
    std::vector<std::int32_t> levels;
    for_each_active(
        tile,
        [&](RowBits active, int y, int z) {
          for_each_sample(active, [&](int x) {
            if (const std::int32_t level = level_at(x, y, z); level != INT32_MIN) {
              levels.push_back(level);
            }
          });
        },
        [](int, int, int, int) {});
    if (levels.empty()) return;
    std::sort(levels.begin(), levels.end());
    ShellHeader header;
    header.values = levels_per_octave == 8 ? ShellValues::kLatticeExact : ShellValues::kQuantized;
    header.levels_per_octave = levels_per_octave;
    header.lattice_resolution = 5;
    header.first_level = levels.front();
    header.levels = levels.back() - levels.front() + 2;
    header.unit_exponent =
        static_cast<std::int32_t>(
            std::floor(static_cast<double>(levels[levels.size() / 2]) / levels_per_octave)) -
        10;
    scale.begin(header);
    CountingCoder coder(model.corrections, corrections);
    count_values(
        tile, LevelMagnitudes(scale), counts,
        [&](int x, int y, int z) {
          const std::int32_t level = level_at(x, y, z);
          return level == INT32_MIN ? 0 : level - header.first_level + 1;
        },
        [&](int x, int y, int z, int direction) {
          if (levels_per_octave != 8) return;
          const EdgeDirection d = kEdgeDirection[direction];
          const double from = static_cast<double>(tile.at(x, y, z));
          const double to = static_cast<double>(tile.at(x + d.x, y + d.y, z + d.z));
          code_cut(coder, model.corrections, scale, header.steps(), rings.levels(y, z)[x],
                   rings.levels(y + d.y, z + d.z)[x + d.x],
                   exact_cut(from, to, tile.isovalue, header.steps()));
        });
  }

  // visit(mask, inputs and output in units of g)
  template <typename Visit>
  void for_each_input(const Tile& tile, const Visit& visit) {
    // Floats as fine integers around the isovalue.
    double unit = 1;
    if (!tile.volume->is_integer) {
      double sum = 0;
      double active_samples = 1;
      for_each_active(
          tile,
          [&](RowBits active, int y, int z) {
            for_each_sample(active, [&](int x) {
              sum += std::abs(static_cast<double>(tile.at(x, y, z)) - tile.isovalue);
              active_samples += 1;
            });
          },
          [](int, int, int, int) {});
      unit = std::max(sum / active_samples / 1024, 1e-30);
    }
    RunningMeans recent = ExactMagnitudes::start();
    for_each_active(
        tile,
        [&](RowBits active, int y, int z) {
          if (!active.any()) return;
          rings.use_row(y, z);
          const SignsAround around(signs, y, z);
          KnownSample* const current = rings.known(y, z);
          const KnownSample* const before = rings.known(y, z - 1);
          for_each_sample(active, [&](int x) {
            const Inputs inputs = inputs_around(around, x, current + x, before + x, recent);
            const double off = (static_cast<double>(tile.at(x, y, z)) - tile.isovalue) / unit;
            const auto m = static_cast<std::int32_t>(std::clamp(
                inputs.is_positive ? std::ceil(off) - 1 : std::floor(-off), 0.0, 65535.0));
            current[x].w = inputs.is_positive ? 2 * m + 1 : -2 * m - 1;
            if (inputs.mask == 0) return;
            std::array<double, kWeights> of{};
            const double g = std::max(1, inputs.g);
            for (std::size_t i = 0; i < kWeights; ++i) of[i] = inputs.of[i] / g;
            visit(inputs.mask, of, current[x].w / g);
          });
        },
        [](int, int, int, int) {});
  }
};

using WeightSets = std::vector<std::array<double, kWeights>>;

double predicted(const std::array<double, kWeights>& weights,
                 const std::array<double, kWeights>& inputs) {
  double sum = 0;
  for (std::size_t i = 0; i < kWeights; ++i) sum += weights[i] * inputs[i];
  return sum;
}

// Rounds of reweighted least squares, which approximate least absolute deviations.
WeightSets trained_weights(Trainer& trainer, const std::vector<TrainingVolume>& volumes) {
  std::array<double, kWeights> common{};
  for (std::size_t i = 0; i < 3; ++i) common[i] = 1.0 / 3;
  WeightSets sets(128, common);
  for (int round = 0; round < 4; ++round) {
    std::vector<Equations> equations(128);
    Equations all;
    for (const TrainingVolume& volume : volumes) {
      std::vector<Equations> mine(128);
      double samples = 0;
      for (const double isovalue : volume.isovalues) {
        for_each_tile(volume, isovalue, [&](const Tile& tile) {
          if (!trainer.find_signs(tile)) return;
          trainer.for_each_input(tile, [&](unsigned mask, const auto& inputs, double output) {
            const double miss = std::abs(output - predicted(sets[mask], inputs));
            mine[mask].add(inputs, output, 1 / (0.3 + miss));
            samples += 1;
          });
        });
      }
      if (samples == 0) continue;
      for (std::size_t mask = 0; mask < 128; ++mask) {
        for (std::size_t i = 0; i < kWeights; ++i) {
          for (std::size_t j = 0; j <= kWeights; ++j) {
            const double share = mine[mask].of[i][j] * 1e5 / samples;
            equations[mask].of[i][j] += share;
            all.of[i][j] += share;
          }
        }
      }
    }
    common = all.solved(common);
    for (std::size_t mask = 0; mask < 128; ++mask) sets[mask] = equations[mask].solved(common);
  }
  return sets;
}

void print_table(const char* name, const std::vector<int>& numbers) {
  constexpr std::size_t kWidth = 100;
  std::cout << "inline constexpr uint8_t " << name << "[" << numbers.size() << "] = {\n";
  std::string line = "   ";
  for (const int number : numbers) {
    const std::string word = " " + std::to_string(number) + ",";
    if (line.size() + word.size() > kWidth) {
      std::cout << line << "\n";
      line = "   ";
    }
    line += word;
  }
  std::cout << line << "\n};\n\n";
}

void print_weights(const std::vector<std::array<int, kWeights>>& sets) {
  std::cout << "inline constexpr int16_t kTrainedWeights[128][11] = {\n";
  for (const auto& weights : sets) {
    std::cout << "    {";
    for (std::size_t i = 0; i < kWeights; ++i) std::cout << (i > 0 ? ", " : "") << weights[i];
    std::cout << "},\n";
  }
  std::cout << "};\n\n";
}

template <std::size_t kCount>
std::vector<int> as_vector(const uint8_t (&table)[kCount]) {
  return {std::begin(table), std::end(table)};
}

int run(const std::string& what, const std::string& list) {
  const std::vector<TrainingVolume> volumes = read_volumes(list);
  const auto trainer = std::make_unique<Trainer>();
  std::vector<std::array<int, kWeights>> weights(128);
  std::vector<int> signs = as_vector(kTrainedSigns);
  std::vector<int> exact = as_vector(kTrainedExactValues);
  std::vector<int> levels = as_vector(kTrainedLevels);
  std::vector<int> corrections = as_vector(kTrainedCorrections);
  for (std::size_t mask = 0; mask < 128; ++mask) {
    std::copy_n(kTrainedWeights[mask], kWeights, weights[mask].begin());
  }
  if (what == "weights") {
    const WeightSets sets = trained_weights(*trainer, volumes);
    for (std::size_t mask = 1; mask < 128; ++mask) {
      for (std::size_t i = 0; i < kWeights; ++i) {
        weights[mask][i] =
            static_cast<int>(std::lround(std::clamp(sets[mask][i], -4.0, 4.0) * 256));
      }
    }
  } else {
    Counts<SignModel> sign_counts;
    Counts<ValueModel> exact_counts;
    Counts<ValueModel> level_counts;
    Counts<CorrectionModel> correction_counts;
    for (const TrainingVolume& volume : volumes) {
      Counts<SignModel> its_signs;
      Counts<ValueModel> its_exact;
      std::array<Counts<ValueModel>, 4> its_levels;
      Counts<CorrectionModel> its_corrections;
      for (const double isovalue : volume.isovalues) {
        for_each_tile(volume, isovalue, [&](const Tile& tile) {
          if (!trainer->find_signs(tile)) return;
          CountingCoder coder(trainer->model.signs, its_signs);
          code_signs(coder, trainer->model.signs, trainer->blocks, trainer->signs);
          if (volume.is_integer) trainer->count_exact(tile, its_exact);
          for (std::size_t i = 0; i < 4; ++i) {
            trainer->count_levels(tile, 1 << i, its_levels[i], its_corrections);
          }
        });
      }
      sign_counts.add(its_signs);
      exact_counts.add(its_exact);
      for (const auto& counts : its_levels) level_counts.add(counts);
      correction_counts.add(its_corrections);
    }
    signs = sign_counts.probabilities();
    exact = exact_counts.probabilities();
    levels = level_counts.probabilities();
    corrections = correction_counts.probabilities();
  }
  std::cout
      << "// Made by tests/bench/train_shell_tables.cpp. Part of the format: other numbers give "
         "other bytes.\n#pragma once\n\n#include <stdint.h>\n\nnamespace multitetra::shell {\n\n"
         "// In units of 2^-8, by which of the seven neighbours are active; see "
         "magnitude_coder.hpp.\n";
  print_weights(weights);
  std::cout
      << "// Where probabilities start: (b + 1/2) / 256, in the order of the members of their "
         "models; see\n// shell_model.hpp.\n";
  print_table("kTrainedSigns", signs);
  print_table("kTrainedExactValues", exact);
  print_table("kTrainedLevels", levels);
  print_table("kTrainedCorrections", corrections);
  std::cout << "}  // namespace multitetra::shell\n";
  return 0;
}

}  // namespace
}  // namespace multitetra::shell

int main(int count, char** arguments) {
  const std::string what = count == 3 ? arguments[1] : "";
  if (what != "weights" && what != "probabilities") {
    std::cerr << "Usage: train_shell_tables weights|probabilities volumes.txt\n";
    return 2;
  }
  try {
    return multitetra::shell::run(what, arguments[2]);
  } catch (const std::exception& failure) {
    std::cerr << failure.what() << "\n";
    return 1;
  }
}
