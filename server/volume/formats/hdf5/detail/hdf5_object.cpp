#include "server/volume/formats/hdf5/detail/hdf5_object.hpp"

#include <algorithm>
#include <array>
#include <system_error>

#include "server/volume/formats/detail/input_file.hpp"
#include "server/volume/formats/hdf5/hdf5_file.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

constexpr int kDeepest = 8;  // Nesting of virtual datasets.
constexpr std::size_t kMaxSources = 100'000;

// Keeps the first error of libhdf5, which the innermost function reports.
herr_t keep_problem(unsigned, const H5E_error2_t* error, void* into) {
  auto& text = *static_cast<std::string*>(into);
  if (error->desc != nullptr && *error->desc != '\0') text = error->desc;
  return 0;
}

// State for checking external links while one is followed.
struct LinkGuard {
  fs::path file;
  bool allow_external_files;
  std::string refusal = {};
};

herr_t guard_link(const char*, const char*, const char* child_file, const char*, unsigned*, hid_t,
                  void* data) {
  auto& guard = *static_cast<LinkGuard*>(data);
  try {
    (void)named_data_file(guard.file, child_file, guard.allow_external_files);
    return 0;
  } catch (const VolumeFileError& problem) {
    guard.refusal = problem.what();
    return -1;
  }
}

// With `from_origin`, external storage is searched in the file's folder; a dataset that is open in
// this way cannot be reopened otherwise.
Hdf5Id opened_guarded(hid_t in, const std::string& name, LinkGuard& guard,
                      bool from_origin = false) {
  const Hdf5Id access(H5Pcreate(H5P_DATASET_ACCESS), &H5Pclose);
  H5Pset_elink_cb(access.get(), &guard_link, &guard);
  if (from_origin) H5Pset_efile_prefix(access.get(), "${ORIGIN}");
  Hdf5Id dataset(H5Dopen2(in, name.c_str(), access.get()), &H5Dclose);
  if (!guard.refusal.empty()) throw VolumeFileError(guard.refusal);
  return dataset;
}

// Reads a text from a libhdf5 function that returns its length first.
template <typename Get>
std::string sized_text(const Get& get) {
  const ssize_t length = get(nullptr, 0);
  std::string text(length > 0 ? static_cast<std::size_t>(length) + 1 : 0, '\0');
  if (length > 0) get(text.data(), text.size());
  return text.substr(0, length > 0 ? static_cast<std::size_t>(length) : 0);
}

void check_external_storage(const fs::path& file, hid_t dataset, hid_t creation,
                            bool allow_external_files) {
  const int count = H5Pget_external_count(creation);
  if (count <= 0) return;
  const Hdf5Id type(H5Dget_type(dataset), &H5Tclose);
  hsize_t needed = H5Tget_size(type.get());
  for (const hsize_t length : hdf5_dims(dataset)) needed *= length;
  for (int i = 0; i < count; ++i) {
    std::array<char, 4096> name{};
    off_t offset = 0;
    hsize_t size = 0;
    H5Pget_external(creation, static_cast<unsigned>(i), name.size() - 1, name.data(), &offset,
                    &size);
    const fs::path data = named_data_file(file, name.data(), allow_external_files);
    const hsize_t here = std::min(size, needed);
    const std::uintmax_t found = fs::file_size(data);
    if (found < static_cast<std::uintmax_t>(offset) ||
        found - static_cast<std::uintmax_t>(offset) < here) {
      fail_damaged(data, "it is external storage of '" + file.filename().string() +
                             "' and has fewer bytes than required");
    }
    needed -= here;
  }
}

void check_dataset(const fs::path& file, hid_t dataset, bool allow_external_files, int depth);

// Returns the file names of a mapping; "%b" numbers the blocks of an unlimited mapping.
std::vector<std::string> source_names(const std::string& pattern, const fs::path& file,
                                      bool allow_external_files) {
  std::vector<std::string> names;
  const auto replaced = [&](std::size_t block) {
    std::string name;
    for (std::size_t i = 0; i < pattern.size(); ++i) {
      const char next = pattern[i] == '%' && i + 1 < pattern.size() ? pattern[i + 1] : '\0';
      if (next == 'b') name += std::to_string(block);
      if (next == '%') name += '%';
      if (next == 'b' || next == '%') {
        ++i;
      } else {
        name += pattern[i];
      }
    }
    return name;
  };
  names.push_back(replaced(0));
  if (names[0] == replaced(1)) return names;
  std::error_code error;
  while (names.size() < kMaxSources &&
         fs::exists(fs::path(file).replace_filename(replaced(names.size())), error)) {
    names.push_back(replaced(names.size()));
  }
  for (const std::string& name : names) (void)named_data_file(file, name, allow_external_files);
  return names;
}

void check_sources(const fs::path& file, hid_t dataset, hid_t creation, bool allow_external_files,
                   int depth) {
  std::size_t count = 0;
  H5Pget_virtual_count(creation, &count);
  if (depth == kDeepest || count > kMaxSources) {
    fail_reading(file, "its virtual dataset has too many sources, or nested sources",
                 "Copy it into one dataset");
  }
  std::string seen_file;
  std::string seen_name;
  for (std::size_t i = 0; i < count; ++i) {
    const std::string pattern = sized_text([&](char* text, std::size_t size) {
      return H5Pget_virtual_filename(creation, i, text, size);
    });
    const std::string name = sized_text([&](char* text, std::size_t size) {
      return H5Pget_virtual_dsetname(creation, i, text, size);
    });
    if (pattern == seen_file && name == seen_name) continue;
    seen_file = pattern;
    seen_name = name;
    const bool is_counted = name.find("%b") != std::string::npos;
    const auto check = [&](hid_t in, const fs::path& in_file) {
      if (is_counted) return;  // Blocks may be missing.
      LinkGuard guard{.file = in_file, .allow_external_files = allow_external_files};
      const Hdf5Id source = opened_guarded(in, name, guard);
      if (!source) {
        fail_reading(file,
                     "a source of its virtual dataset, '" + name + "' in '" +
                         in_file.filename().string() + "', is missing",
                     "Get all of its files");
      }
      check_dataset(in_file, source.get(), allow_external_files, depth + 1);
    };
    if (pattern == ".") {
      const Hdf5Id own(H5Iget_file_id(dataset), &H5Fclose);
      check(own.get(), file);
      continue;
    }
    for (const std::string& source_name : source_names(pattern, file, allow_external_files)) {
      const fs::path source_file = named_data_file(file, source_name, allow_external_files);
      const Hdf5Id opened = open_hdf5_file(source_file);
      check(opened.get(), source_file);
    }
  }
}

void check_dataset(const fs::path& file, hid_t dataset, bool allow_external_files, int depth) {
  const Hdf5Id creation(H5Dget_create_plist(dataset), &H5Pclose);
  if (depth > 0 && H5Pget_external_count(creation.get()) > 0) {
    // libhdf5 would search in the working directory.
    fail_reading(file, "a source of a virtual dataset has its samples in another file",
                 "Copy it into one dataset");
  }
  check_external_storage(file, dataset, creation.get(), allow_external_files);
  if (H5Pget_layout(creation.get()) == H5D_VIRTUAL) {
    check_sources(file, dataset, creation.get(), allow_external_files, depth);
  }
}

}  // namespace

std::vector<hsize_t> hdf5_dims(hid_t dataset) {
  const Hdf5Id space(H5Dget_space(dataset), &H5Sclose);
  const int rank = H5Sget_simple_extent_ndims(space.get());
  std::vector<hsize_t> dims(rank > 0 ? static_cast<std::size_t>(rank) : 0);
  if (rank > 0) H5Sget_simple_extent_dims(space.get(), dims.data(), nullptr);
  return dims;
}

std::vector<double> hdf5_numbers(hid_t object, const char* name, std::size_t most) {
  if (H5Aexists(object, name) <= 0) return {};
  const Hdf5Id attribute(H5Aopen(object, name, H5P_DEFAULT), &H5Aclose);
  const Hdf5Id space(H5Aget_space(attribute.get()), &H5Sclose);
  const Hdf5Id type(H5Aget_type(attribute.get()), &H5Tclose);
  const H5T_class_t kind = H5Tget_class(type.get());
  const hssize_t count = H5Sget_simple_extent_npoints(space.get());
  if ((kind != H5T_FLOAT && kind != H5T_INTEGER) || count < 1 ||
      count > static_cast<hssize_t>(most))
    return {};
  std::vector<double> numbers(static_cast<std::size_t>(count));
  if (H5Aread(attribute.get(), H5T_NATIVE_DOUBLE, numbers.data()) < 0) return {};
  return numbers;
}

std::string hdf5_text(hid_t object, const char* name) {
  constexpr std::size_t kMaxTextBytes = 4096;
  if (H5Aexists(object, name) <= 0) return {};
  const Hdf5Id attribute(H5Aopen(object, name, H5P_DEFAULT), &H5Aclose);
  const Hdf5Id type(H5Aget_type(attribute.get()), &H5Tclose);
  const Hdf5Id space(H5Aget_space(attribute.get()), &H5Sclose);
  const hssize_t count = H5Sget_simple_extent_npoints(space.get());
  if (H5Tget_class(type.get()) != H5T_STRING || count < 1) return {};
  if (H5Tis_variable_str(type.get()) > 0) {
    char* text = nullptr;
    if (count != 1 || H5Aread(attribute.get(), type.get(), &text) < 0 || text == nullptr) return {};
    std::string result(text);
    H5free_memory(text);
    return result;
  }
  const std::size_t size = H5Tget_size(type.get());
  if ((count != 1 && size != 1) || static_cast<std::size_t>(count) * size > kMaxTextBytes)
    return {};
  std::string text(static_cast<std::size_t>(count) * size, '\0');
  if (H5Aread(attribute.get(), type.get(), text.data()) < 0) return {};
  return text.substr(0, text.find('\0'));
}

Hdf5Id open_hdf5_file(const fs::path& file) {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  const InputFile input(file);  // Reports errors of the file itself.
  const Hdf5Id access(H5Pcreate(H5P_FILE_ACCESS), &H5Pclose);
  H5Pset_file_locking(access.get(), false, true);  // Other programs may have the file open.
  Hdf5Id opened(H5Fopen(file.c_str(), H5F_ACC_RDONLY, access.get()), &H5Fclose);
  if (opened) return opened;
  std::string problem;
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, &keep_problem, &problem);
  if (!is_hdf5(input.beginning(4096))) {
    fail_reading(file, "it is not an HDF5 or NetCDF file", "Check the program that wrote it");
  }
  std::string innermost;
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_DOWNWARD, &keep_problem, &innermost);
  if (innermost.empty()) innermost = problem;
  fail_reading(file, "libhdf5 cannot open it: " + innermost.substr(0, 300),
               "Get a complete copy of the file, or write it for older readers (libver 'v110')");
}

std::optional<Hdf5Id> open_hdf5_dataset(const fs::path& file, hid_t in, const std::string& name,
                                        bool allow_external_files) {
  LinkGuard guard{.file = file, .allow_external_files = allow_external_files};
  {
    Hdf5Id dataset = opened_guarded(in, name, guard);
    if (!dataset) return std::nullopt;
    const Hdf5Id own(H5Iget_file_id(dataset.get()), &H5Fclose);
    const std::string real = sized_text(
        [&](char* text, std::size_t size) { return H5Fget_name(own.get(), text, size); });
    check_dataset(real.empty() ? file : fs::path(real), dataset.get(), allow_external_files, 0);
    const Hdf5Id creation(H5Dget_create_plist(dataset.get()), &H5Pclose);
    if (H5Pget_external_count(creation.get()) <= 0) return dataset;
  }
  return opened_guarded(in, name, guard, /*from_origin=*/true);
}

}  // namespace multitetra
