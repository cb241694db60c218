#include "server/volume/formats/hdf5/detail/hdf5_object.hpp"

#include <algorithm>
#include <array>
#include <limits>
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

// Returns the file that contains a dataset, which a link in `opened` may have led to.
fs::path file_of(hid_t dataset, const fs::path& opened) {
  const Hdf5Id own(H5Iget_file_id(dataset), &H5Fclose);
  const std::string real =
      sized_text([&](char* text, std::size_t size) { return H5Fget_name(own.get(), text, size); });
  return real.empty() ? opened : fs::path(real);
}

void check_external_storage(const fs::path& file, hid_t dataset, hid_t creation,
                            bool allow_external_files) {
  const int count = H5Pget_external_count(creation);
  if (count <= 0) return;
  hsize_t needed = hdf5_bytes(dataset);
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
      fail_incomplete(data, "it is external storage of '" + file.filename().string() +
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

// Returns the bounds of a selection; empty if unlimited.
Hdf5Box bounds_of(hid_t space) {
  const int rank = H5Sget_simple_extent_ndims(space);
  Hdf5Box box;
  std::vector<hsize_t> end(rank > 0 ? static_cast<std::size_t>(rank) : 0);
  box.start.resize(end.size());
  if (rank <= 0 || H5Sget_select_bounds(space, box.start.data(), end.data()) < 0) return {};
  for (std::size_t d = 0; d < end.size(); ++d) {
    if (end[d] == H5S_UNLIMITED) return {};
    box.extent.push_back(end[d] - box.start[d] + 1);
  }
  return box;
}

void check_sources(const fs::path& file, hid_t dataset, bool allow_external_files, int depth) {
  if (depth == kDeepest) {
    fail_reading(file, "its virtual dataset has nested sources", "Copy it into one dataset");
  }
  const Hdf5Mapping* seen = nullptr;
  const std::vector<Hdf5Mapping> mappings = hdf5_mappings(file, dataset, allow_external_files);
  for (const Hdf5Mapping& mapping : mappings) {
    const Hdf5Mapping* const before = std::exchange(seen, &mapping);
    if (before && before->file == mapping.file && before->dataset == mapping.dataset) continue;
    const Hdf5Id opened = open_hdf5_file(mapping.file);
    LinkGuard guard{.file = mapping.file, .allow_external_files = allow_external_files};
    const Hdf5Id source = opened_guarded(opened.get(), mapping.dataset, guard);
    if (!source) {
      fail_reading(file,
                   "a source of its virtual dataset, '" + mapping.dataset + "' in '" +
                       mapping.file.filename().string() + "', is missing",
                   "Get all of its files");
    }
    check_dataset(mapping.file, source.get(), allow_external_files, depth + 1);
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
    check_sources(file, dataset, allow_external_files, depth);
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

hsize_t hdf5_bytes(hid_t dataset) {
  const Hdf5Id type(H5Dget_type(dataset), &H5Tclose);
  hsize_t bytes = H5Tget_size(type.get());
  for (const hsize_t length : hdf5_dims(dataset)) {
    if (__builtin_mul_overflow(bytes, length, &bytes)) return std::numeric_limits<hsize_t>::max();
  }
  return bytes;
}

Hdf5Box whole_box(std::vector<hsize_t> dims) {
  Hdf5Box box{.start = std::vector<hsize_t>(dims.size(), 0), .extent = {}};
  box.extent = std::move(dims);
  return box;
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

std::vector<std::string> hdf5_texts(hid_t object, const char* name) {
  constexpr hssize_t kMaxTexts = 1024;
  constexpr std::size_t kMaxTextBytes = std::size_t{1} << 16;
  if (H5Aexists(object, name) <= 0) return {};
  const Hdf5Id attribute(H5Aopen(object, name, H5P_DEFAULT), &H5Aclose);
  const Hdf5Id type(H5Aget_type(attribute.get()), &H5Tclose);
  const Hdf5Id space(H5Aget_space(attribute.get()), &H5Sclose);
  const hssize_t count = H5Sget_simple_extent_npoints(space.get());
  if (H5Tget_class(type.get()) != H5T_STRING || count < 1 || count > kMaxTexts) return {};
  const auto texts_count = static_cast<std::size_t>(count);
  std::vector<std::string> texts;
  if (H5Tis_variable_str(type.get()) > 0) {
    std::vector<char*> pointers(texts_count, nullptr);
    if (H5Aread(attribute.get(), type.get(), pointers.data()) < 0) return {};
    for (char* const text : pointers) {
      texts.emplace_back(text == nullptr ? "" : text);
      H5free_memory(text);
    }
    return texts;
  }
  const std::size_t size = H5Tget_size(type.get());
  if (size == 0 || size > kMaxTextBytes) return {};
  std::string all(texts_count * size, '\0');
  if (H5Aread(attribute.get(), type.get(), all.data()) < 0) return {};
  for (std::size_t i = 0; i < texts_count; ++i) {
    const std::string text = all.substr(i * size, size);
    texts.push_back(text.substr(0, text.find('\0')));
  }
  return texts;
}

Hdf5Id open_hdf5_object(const fs::path& file, hid_t in, const std::string& name,
                        bool allow_external_files) {
  LinkGuard guard{.file = file, .allow_external_files = allow_external_files};
  const Hdf5Id access(H5Pcreate(H5P_LINK_ACCESS), &H5Pclose);
  H5Pset_elink_cb(access.get(), &guard_link, &guard);
  return {H5Oopen(in, name.c_str(), access.get()), &H5Oclose};
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
               "Compare it with another copy, or write it for older readers (libver 'v110')");
}

std::optional<Hdf5Id> open_hdf5_dataset(const fs::path& file, hid_t in, const std::string& name,
                                        bool allow_external_files) {
  LinkGuard guard{.file = file, .allow_external_files = allow_external_files};
  {
    Hdf5Id dataset = opened_guarded(in, name, guard);
    if (!dataset) return std::nullopt;
    check_dataset(file_of(dataset.get(), file), dataset.get(), allow_external_files, 0);
    const Hdf5Id creation(H5Dget_create_plist(dataset.get()), &H5Pclose);
    if (H5Pget_external_count(creation.get()) <= 0) return dataset;
  }
  return opened_guarded(in, name, guard, /*from_origin=*/true);
}

std::vector<Hdf5Mapping> hdf5_mappings(const fs::path& opened, hid_t dataset,
                                       bool allow_external_files) {
  const fs::path file = file_of(dataset, opened);
  const Hdf5Id creation(H5Dget_create_plist(dataset), &H5Pclose);
  std::size_t count = 0;
  H5Pget_virtual_count(creation.get(), &count);
  std::vector<Hdf5Mapping> mappings;
  for (std::size_t i = 0; i < count; ++i) {
    const std::string pattern = sized_text([&](char* text, std::size_t size) {
      return H5Pget_virtual_filename(creation.get(), i, text, size);
    });
    const std::string name = sized_text([&](char* text, std::size_t size) {
      return H5Pget_virtual_dsetname(creation.get(), i, text, size);
    });
    if (name.find("%b") != std::string::npos) {
      fail_reading(file, "the sources of its virtual dataset are numbered, '" + name + "'",
                   "Copy it into one dataset");
    }
    const Hdf5Id in_virtual(H5Pget_virtual_vspace(creation.get(), i), &H5Sclose);
    const Hdf5Id in_source(H5Pget_virtual_srcspace(creation.get(), i), &H5Sclose);
    Hdf5Mapping mapping{.file = file,
                        .dataset = name,
                        .in_virtual = bounds_of(in_virtual.get()),
                        .in_source = bounds_of(in_source.get())};
    std::vector<hsize_t> dims = hdf5_dims(dataset);
    if (mapping.in_virtual.start.size() != dims.size()) {
      mapping.in_virtual = whole_box(std::move(dims));
    }
    std::vector<std::string> files = {pattern};
    if (pattern != ".") files = source_names(pattern, file, allow_external_files);
    if (mappings.size() + files.size() > kMaxSources) {
      fail_reading(file, "its virtual dataset has too many sources", "Copy it into one dataset");
    }
    for (const std::string& source : files) {
      if (source != ".") mapping.file = named_data_file(file, source, allow_external_files);
      mappings.push_back(mapping);
    }
  }
  return mappings;
}

}  // namespace multitetra
