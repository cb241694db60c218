#include "common/codec/plain_box.hpp"

namespace multitetra::shell {

namespace {

enum class PlainType : uint8_t { kU8, kI8, kU16, kI16, kF32 };

template <typename Number>
Number number_at(const uint8_t* bytes, size_t at) {
  Number number;
  __builtin_memcpy(&number, bytes + at, sizeof(number));
  return number;
}

PlainType type_of(const uint8_t* bytes) { return static_cast<PlainType>(bytes[1]); }

// Returns what `act` returns for a value of the samples' type.
template <typename Act>
auto with_type(PlainType type, const Act& act) {
  switch (type) {
    case PlainType::kU8:
      return act(uint8_t{});
    case PlainType::kI8:
      return act(int8_t{});
    case PlainType::kU16:
      return act(uint16_t{});
    case PlainType::kI16:
      return act(int16_t{});
    default:
      return act(float{});
  }
}

// The samples of a box and of the layers around them.
template <typename Sample>
class PlainSamples {
 public:
  PlainSamples(const uint8_t* bytes, const ShellHeader& header)
      : first_(bytes + kPlainHeaderBytes), layer_value_(header.layer_value) {
    for (int axis = 0; axis < 3; ++axis) {
      low_[axis] = header.layer(axis, false);
      count_[axis] = header.data_samples(axis);
    }
  }

  // Coordinates in the data.
  [[nodiscard]] Sample sample(int x, int y, int z) const {
    const int at = x + count_[0] * (y + count_[1] * z);
    return number_at<Sample>(first_, sizeof(Sample) * static_cast<size_t>(at));
  }
  // Coordinates in the box.
  [[nodiscard]] double value(int x, int y, int z) const {
    const int at[3] = {x - low_[0], y - low_[1], z - low_[2]};
    for (int axis = 0; axis < 3; ++axis) {
      if (at[axis] < 0 || at[axis] >= count_[axis]) return static_cast<double>(layer_value_);
    }
    return static_cast<double>(sample(at[0], at[1], at[2]));
  }
  [[nodiscard]] int count(int axis) const { return count_[axis]; }

 private:
  const uint8_t* first_;
  float layer_value_;
  int low_[3];
  int count_[3];
};

// Sets the bits of the samples for which holds(sample).
template <typename Sample, typename Holds>
void fill_field(const PlainSamples<Sample>& samples, const Holds& holds, BitField& field) {
  field.begin(samples.count(0), samples.count(1), samples.count(2));
  for (int z = 0; z < samples.count(2); ++z) {
    for (int y = 0; y < samples.count(1); ++y) {
      uint64_t words[2] = {};
      for (int x = 0; x < samples.count(0); ++x) {
        words[x >> 6] |= uint64_t{holds(samples.sample(x, y, z)) ? 1U : 0U} << (x & 63);
      }
      field.row(y, z) = of_previous({words[0], words[1]});
    }
  }
}

// Finds void samples; returns false if a sample is infinite.
bool find_void(const uint8_t* bytes, ShellHeader& header) {
  if (type_of(bytes) != PlainType::kF32) return true;
  const PlainSamples<float> samples(bytes, header);
  const int count = samples.count(0) * samples.count(1) * samples.count(2);
  for (int i = 0; i < count; ++i) {
    const float sample = samples.sample(i, 0, 0);
    if (sample - sample == 0) continue;
    if (sample == sample) return false;
    header.has_void = true;
  }
  return true;
}

// Returns whether the box lies on the lattice and has a valid size.
bool read_box(const uint8_t* bytes, ShellHeader& header) {
  constexpr int64_t kLimit = int64_t{1} << kMaxShellLatticeBits;
  for (int axis = 0; axis < 3; ++axis) {
    const size_t at = 4 * static_cast<size_t>(axis);
    header.origin[axis] = number_at<int32_t>(bytes, 4 + at);
    header.samples[axis] = number_at<int32_t>(bytes, 16 + at);
    if (header.samples[axis] < 2 || header.samples[axis] > kMaxShellSamples ||
        header.data_samples(axis) < 1 || header.origin[axis] < 0 ||
        (int64_t{header.origin[axis]} + header.samples[axis] - 1) * header.steps() > kLimit) {
      return false;
    }
  }
  return true;
}

}  // namespace

ShellStatus read_plain_header(const uint8_t* bytes, size_t size, ShellHeader& header) {
  header = {};
  if (size < 1 || bytes[0] != kPlainVersion) return ShellStatus::kUnknownVersion;
  if (size < kPlainHeaderBytes || type_of(bytes) > PlainType::kF32) return ShellStatus::kBadHeader;
  header.lattice_resolution = bytes[2] & 15;
  header.spacing_exponent = bytes[2] >> 4;
  header.layers = bytes[3];
  if (header.lattice_resolution < 1 || header.lattice_resolution > 8 || header.layers >= 64 ||
      !read_box(bytes, header)) {
    return ShellStatus::kBadHeader;
  }
  header.vertices = number_at<uint32_t>(bytes, 28);
  header.triangles = number_at<uint32_t>(bytes, 32);
  header.layer_value = number_at<float>(bytes, 36);
  header.isovalue = number_at<double>(bytes, 40);
  header.layer_is_positive = static_cast<double>(header.layer_value) > header.isovalue;
  const bool are_numbers = header.isovalue - header.isovalue == 0 &&
                           (header.layers == 0 || header.layer_value - header.layer_value == 0);
  const auto samples =
      static_cast<size_t>(header.data_samples(0) * header.data_samples(1) * header.data_samples(2));
  const size_t a_sample = with_type(type_of(bytes), [](auto sample) { return sizeof(sample); });
  if (!are_numbers || header.vertices > max_vertices(header) ||
      header.triangles > max_triangles(header) || size != kPlainHeaderBytes + a_sample * samples) {
    return ShellStatus::kBadHeader;
  }
  return find_void(bytes, header) ? ShellStatus::kOk : ShellStatus::kBadContents;
}

void PlainBoxMarcher::find_signs(const uint8_t* bytes, const ShellHeader& header) {
  const int low[3] = {header.layer(0, false), header.layer(1, false), header.layer(2, false)};
  const auto finish = [&](BitField& field, bool of_layers) {
    if (header.layers != 0) field.enclose(low, header.samples, of_layers);
    field.finish();
  };
  with_type(type_of(bytes), [&]<typename Sample>(Sample) {
    const PlainSamples<Sample> samples(bytes, header);
    fill_field(
        samples, [&](Sample s) { return static_cast<double>(s) > header.isovalue; }, signs_);
    if (header.has_void)
      fill_field(
          samples, [](Sample s) { return s == s; }, present_);
  });
  finish(signs_, header.layer_is_positive);
  if (header.has_void) finish(present_, true);
}

bool PlainBoxMarcher::march(const uint8_t* bytes, const ShellHeader& header, ShellVertex* vertices,
                            ShellTriangle* triangles) {
  find_signs(bytes, header);
  const BitField* const present = header.has_void ? &present_ : nullptr;
  edges_.begin(signs_, present, header.origin);
  marching_.begin(signs_, present, header);
  return with_type(type_of(bytes), [&]<typename Sample>(Sample) {
    const PlainSamples<Sample> samples(bytes, header);
    const auto cut_in = [&](int z) {
      return [&, z](int x, int y, int direction) {
        const EdgeDirection d = kEdgeDirection[direction];
        const double from = samples.value(x, y, z);
        const double to = samples.value(x + d.x, y + d.y, z + d.z);
        return begins_at_other_end(d)
                   ? header.steps() - exact_cut(to, from, header.isovalue, header.steps())
                   : exact_cut(from, to, header.isovalue, header.steps());
      };
    };
    for (int z = 0; z < header.samples[2]; ++z) {
      edges_.find(z);
      if (z > 0 && !marching_.add_vertices(edges_, z - 1, kDirectionsInSlice, kEdgeDirections,
                                           vertices, cut_in(z - 1))) {
        return false;
      }
      if (!marching_.add_vertices(edges_, z, 0, kDirectionsInSlice, vertices, cut_in(z)) ||
          (z > 0 && !marching_.add_cells(z - 1, vertices, triangles))) {
        return false;
      }
    }
    return true;
  });
}

ShellStatus PlainBoxMarcher::decode(const uint8_t* bytes, const ShellHeader& header,
                                    ShellVertex* vertices, ShellTriangle* triangles) {
  const bool is_as_promised = march(bytes, header, vertices, triangles) &&
                              marching_.vertices() == header.vertices &&
                              marching_.triangles() == header.triangles;
  return is_as_promised ? ShellStatus::kOk : ShellStatus::kBadContents;
}

void PlainBoxMarcher::count(const uint8_t* bytes, ShellHeader& header, ShellVertex* vertices,
                            ShellTriangle* triangles) {
  header.vertices = max_vertices(header);
  header.triangles = max_triangles(header);
  if (header.has_void) {
    static_cast<void>(march(bytes, header, vertices, triangles));
    header.vertices = marching_.vertices();
    header.triangles = marching_.triangles();
    return;
  }
  find_signs(bytes, header);
  edges_.begin(signs_, nullptr, header.origin);
  marching_.begin(signs_, nullptr, header);
  header.vertices = header.triangles = 0;
  for (int z = 0; z < header.samples[2]; ++z) {
    edges_.find(z);
    for (int y = 0; y < header.samples[1]; ++y) {
      if (!edges_.any(y, z)) continue;
      for (int d = 0; d < kEdgeDirections; ++d) {
        header.vertices += static_cast<uint32_t>(multitetra::shell::count(edges_.crossed(d, y, z)));
      }
    }
    if (z > 0) header.triangles += marching_.count_triangles(z - 1);
  }
}

}  // namespace multitetra::shell
