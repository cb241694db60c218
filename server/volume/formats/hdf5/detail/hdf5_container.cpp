#include "server/volume/formats/hdf5/detail/hdf5_container.hpp"

#include <hdf5_hl.h>

#include <algorithm>
#include <array>
#include <exception>
#include <utility>

#include "server/volume/formats/hdf5/detail/hdf5_chunks.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxDatasets = 10'000;

std::optional<StoredType> type_of_dataset(hid_t dataset) {
  const Hdf5Id type(H5Dget_type(dataset), &H5Tclose);
  const H5T_class_t kind = H5Tget_class(type.get());
  const std::size_t bytes = H5Tget_size(type.get());
  if (kind == H5T_FLOAT) {
    if (bytes <= 4) return StoredType::kF32;
    return bytes == 8 ? std::optional(StoredType::kF64) : std::nullopt;
  }
  if (kind == H5T_ENUM && bytes == 1) return StoredType::kI8;  // h5py's booleans.
  if (kind != H5T_INTEGER) return std::nullopt;
  const bool is_signed = H5Tget_sign(type.get()) != H5T_SGN_NONE;
  return stored_type_from((is_signed ? "i" : "u") + std::to_string(8 * bytes));
}

hid_t memory_type(StoredType type) {
  const std::array<hid_t, 10> types = {
      H5T_NATIVE_UINT8,  H5T_NATIVE_INT8,  H5T_NATIVE_UINT16, H5T_NATIVE_INT16, H5T_NATIVE_FLOAT,
      H5T_NATIVE_UINT32, H5T_NATIVE_INT32, H5T_NATIVE_UINT64, H5T_NATIVE_INT64, H5T_NATIVE_DOUBLE};
  return types[static_cast<std::size_t>(type)];
}

herr_t note_dataset(hid_t group, const char* name, const H5O_info_t* info, void* found) {
  if (info->type != H5O_TYPE_DATASET) return 0;
  auto& names = *static_cast<std::vector<std::string>*>(found);
  if (names.size() >= kMaxDatasets) return 1;
  const Hdf5Id dataset(H5Dopen2(group, name, H5P_DEFAULT), &H5Dclose);
  if (!dataset) return 0;
  std::size_t sides = 0;
  for (const hsize_t length : hdf5_dims(dataset.get())) sides += length > 1;
  if (sides >= 2 && type_of_dataset(dataset.get())) names.emplace_back(std::string("/") + name);
  return 0;
}

bool is_elsewhere(hid_t dataset) {
  const Hdf5Id creation(H5Dget_create_plist(dataset), &H5Pclose);
  return H5Pget_external_count(creation.get()) > 0 || H5Pget_layout(creation.get()) == H5D_VIRTUAL;
}

// Takes the path of the first scale of a dimension.
herr_t note_scale(hid_t, unsigned, hid_t scale, void* into) {
  std::array<char, 1024> name{};
  const ssize_t length = H5Iget_name(scale, name.data(), name.size());
  if (length > 0) *static_cast<std::string*>(into) = name.data();
  return 1;
}

std::string scale_of(hid_t dataset, std::size_t dimension) {
  std::string path;
  const auto d = static_cast<unsigned>(dimension);
  if (H5DSget_num_scales(dataset, d) > 0) {
    H5DSiterate_scales(dataset, d, nullptr, &note_scale, &path);
  }
  return path;
}

class Hdf5Reader : public ArrayReader {
 public:
  Hdf5Reader(fs::path path, Hdf5Id file, Hdf5Id dataset, bool allow_external_files)
      : path_(std::move(path)),
        file_(std::move(file)),
        dataset_(std::move(dataset)),
        type_(memory_type(type_of_dataset(dataset_.get()).value_or(StoredType::kF64))),
        chunk_sizes_(path_, dataset_.get(), allow_external_files) {}

  void read(const std::vector<std::int64_t>& start, const std::vector<std::int64_t>& extent,
            std::byte* into) override {
    const Hdf5Box box{.start = {start.begin(), start.end()},
                      .extent = {extent.begin(), extent.end()}};
    chunk_sizes_.require_whole(dataset_.get(), box);
    const Hdf5Id space(H5Dget_space(dataset_.get()), &H5Sclose);
    const Hdf5Id memory(
        H5Screate_simple(static_cast<int>(box.extent.size()), box.extent.data(), nullptr),
        &H5Sclose);
    H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, box.start.data(), nullptr, box.extent.data(),
                        nullptr);
    if (H5Dread(dataset_.get(), type_, memory.get(), space.get(), H5P_DEFAULT, into) >= 0) return;
    fail_damaged(path_, "a part of its samples cannot be read");
  }

 private:
  fs::path path_;
  Hdf5Id file_;
  Hdf5Id dataset_;
  hid_t type_;
  Hdf5ChunkSizes chunk_sizes_;
};

}  // namespace

Hdf5Id Hdf5Container::object(const std::string& path) const {
  return open_hdf5_object(path_, file_, path.empty() ? "/" : path, allow_external_files_);
}

Hdf5Id Hdf5Container::dataset(const std::string& path) const {
  Hdf5Id found = object(path);
  const bool is_dataset = found && H5Iget_type(found.get()) == H5I_DATASET;
  return is_dataset ? std::move(found) : Hdf5Id(-1, &H5Oclose);
}

std::vector<std::string> Hdf5Container::arrays() const {
  if (!std::exchange(is_searched_, true)) {
    H5Ovisit2(file_, H5_INDEX_NAME, H5_ITER_NATIVE, &note_dataset, &arrays_, H5O_INFO_BASIC);
  }
  return arrays_;
}

std::vector<std::string> Hdf5Container::children(const std::string& path) const {
  std::vector<std::string> names;
  const Hdf5Id group = object(path);
  H5G_info_t info{};
  if (!group || H5Iget_type(group.get()) == H5I_DATASET || H5Gget_info(group.get(), &info) < 0)
    return names;
  for (hsize_t i = 0; i < std::min<hsize_t>(info.nlinks, kMaxDatasets); ++i) {
    std::array<char, 1024> name{};
    const ssize_t length = H5Lget_name_by_idx(group.get(), ".", H5_INDEX_NAME, H5_ITER_INC, i,
                                              name.data(), name.size(), H5P_DEFAULT);
    if (length > 0) names.emplace_back(name.data());
  }
  return names;
}

std::vector<std::int64_t> Hdf5Container::shape(const std::string& array) const {
  const Hdf5Id found = dataset(array);
  if (!found || !type_of_dataset(found.get())) return {};
  std::vector<std::int64_t> shape;
  for (const hsize_t side : hdf5_dims(found.get())) {
    shape.push_back(static_cast<std::int64_t>(std::min<hsize_t>(side, hsize_t{1} << 62)));
  }
  return shape;
}

std::optional<StoredType> Hdf5Container::type(const std::string& array) const {
  const Hdf5Id found = dataset(array);
  return found ? type_of_dataset(found.get()) : std::nullopt;
}

std::vector<double> Hdf5Container::values(const std::string& array) const {
  const Hdf5Id found = dataset(array);
  if (!found || !type_of_dataset(found.get()) || is_elsewhere(found.get())) return {};
  const std::vector<hsize_t> dims = hdf5_dims(found.get());
  hsize_t count = 1;
  for (const hsize_t side : dims) {
    if (__builtin_mul_overflow(count, side, &count) || count == 0 || count > kMaxValues) return {};
  }
  Hdf5ChunkSizes(path_, found.get(), false).require_whole(found.get(), whole_box(dims));
  std::vector<double> values(count);
  const bool is_read =
      H5Dread(found.get(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) >= 0;
  return is_read ? values : std::vector<double>();
}

std::vector<double> Hdf5Container::numbers(const std::string& path, const char* attribute) const {
  const Hdf5Id found = object(path);
  return found ? hdf5_numbers(found.get(), attribute, 1024) : std::vector<double>();
}

std::vector<std::string> Hdf5Container::texts(const std::string& path,
                                              const char* attribute) const {
  const Hdf5Id found = object(path);
  return found ? hdf5_texts(found.get(), attribute) : std::vector<std::string>();
}

std::vector<std::string> Hdf5Container::dimension_names(const std::string& array) const {
  const Hdf5Id found = dataset(array);
  if (!found) return {};
  std::vector<std::string> names(hdf5_dims(found.get()).size());
  for (std::size_t d = 0; d < names.size(); ++d) {
    std::array<char, 256> label{};
    if (H5DSget_label(found.get(), static_cast<unsigned>(d), label.data(), label.size()) > 0) {
      names[d] = label.data();
    } else {
      const std::string scale = scale_of(found.get(), d);
      names[d] = scale.substr(scale.rfind('/') + 1);
    }
  }
  return names;
}

std::string Hdf5Container::coordinates(const std::string& array, std::size_t dimension) const {
  const Hdf5Id found = dataset(array);
  const std::string scale = found ? scale_of(found.get(), dimension) : std::string();
  // NetCDF-4 without its mark stores dimensions without coordinates as scales of this name.
  const bool has_values = !text(scale, "NAME").starts_with("This is a netCDF dimension but not");
  return has_values ? scale : std::string();
}

std::string unwritten_notice(const fs::path& path, hid_t file, const std::string& dataset,
                             bool allow_external_files) {
  const std::optional<Hdf5Id> found = open_hdf5_dataset(path, file, dataset, allow_external_files);
  if (!found || is_elsewhere(found->get())) return {};
  const Hdf5Id creation(H5Dget_create_plist(found->get()), &H5Pclose);
  const H5D_layout_t layout = H5Pget_layout(creation.get());
  const std::string name = "'" + path.string() + "': ";
  if (layout == H5D_CONTIGUOUS && H5Dget_storage_size(found->get()) == 0)
    return name + "its samples were never written; they have the dataset's fill value.";
  if (layout != H5D_CHUNKED) return {};
  const std::vector<hsize_t> dims = hdf5_dims(found->get());
  std::vector<hsize_t> chunk(dims.size());
  const int rank = H5Pget_chunk(creation.get(), static_cast<int>(chunk.size()), chunk.data());
  if (rank != static_cast<int>(dims.size())) return {};
  hsize_t all = 1;
  for (std::size_t d = 0; d < dims.size(); ++d) {
    if (chunk[d] == 0 || __builtin_mul_overflow(all, (dims[d] + chunk[d] - 1) / chunk[d], &all))
      return {};
  }
  const Hdf5Id space(H5Dget_space(found->get()), &H5Sclose);
  hsize_t written = 0;
  if (H5Dget_num_chunks(found->get(), space.get(), &written) < 0 || written >= all) return {};
  return name + std::to_string(all - written) + " of " + std::to_string(all) +
         " chunks were never written; their samples have the dataset's fill value.";
}

std::unique_ptr<ArrayReader> hdf5_reader(const fs::path& path, Hdf5Id file,
                                         const std::string& dataset, bool allow_external_files) {
  std::optional<Hdf5Id> found = open_hdf5_dataset(path, file.get(), dataset, allow_external_files);
  if (!found)
    fail_reading(path, "it has no dataset '" + dataset + "'", "Check the path inside the file");
  return std::make_unique<Hdf5Reader>(path, std::move(file), *std::move(found),
                                      allow_external_files);
}

}  // namespace multitetra
