#include "server/volume/formats/volume_formats.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "common/base/open_file.hpp"
#include "common/base/text.hpp"
#include "server/volume/formats/arrays/bdv_description.hpp"
#include "server/volume/formats/cube_file.hpp"
#include "server/volume/formats/described_raw.hpp"
#include "server/volume/formats/detail/header_bytes.hpp"
#include "server/volume/formats/detail/input_file.hpp"
#include "server/volume/formats/detail/tiff_description.hpp"
#include "server/volume/formats/detail/zip_store.hpp"
#include "server/volume/formats/dicom/dicom_series.hpp"
#include "server/volume/formats/hdf5/hdf5_file.hpp"
#include "server/volume/formats/image_stack.hpp"
#include "server/volume/formats/meta_image_file.hpp"
#include "server/volume/formats/mgh_file.hpp"
#include "server/volume/formats/mrc_file.hpp"
#include "server/volume/formats/netcdf_file.hpp"
#include "server/volume/formats/nifti_file.hpp"
#include "server/volume/formats/npy_file.hpp"
#include "server/volume/formats/nrrd_file.hpp"
#include "server/volume/formats/tiff_file.hpp"
#include "server/volume/formats/vtk/legacy_vtk_file.hpp"
#include "server/volume/formats/vtk/pvti_file.hpp"
#include "server/volume/formats/vtk/vti_file.hpp"
#include "server/volume/formats/zarr/zarr_volume.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kSniffedBytes = 4096;
constexpr std::size_t kDicomBeginning = 132;

// ---- beginnings and openers of formats whose readers have no such function

bool begins_nrrd(std::string_view bytes) { return bytes.starts_with("NRRD000"); }

bool begins_meta_image(std::string_view bytes) {
  return bytes.starts_with("ObjectType") || bytes.starts_with("NDims") ||
         (bytes.starts_with("Comment") && bytes.find("NDims") != std::string_view::npos);
}

bool begins_vtk_xml(std::string_view bytes) {
  return bytes.starts_with("<VTKFile") ||
         (bytes.starts_with("<?xml") && bytes.find("<VTKFile") != std::string_view::npos);
}

bool begins_legacy_vtk(std::string_view bytes) { return bytes.starts_with("# vtk DataFile"); }

bool begins_tiff(std::string_view bytes) {
  using namespace std::string_view_literals;
  return bytes.starts_with("II*\0"sv) || bytes.starts_with("MM\0*"sv) ||
         bytes.starts_with("II+\0"sv) || bytes.starts_with("MM\0+"sv) || is_ome_xml(bytes);
}

bool begins_picture(std::string_view bytes) {
  return bytes.starts_with("\x89PNG") || bytes.starts_with("\xFF\xD8\xFF");
}

StoredVolume open_dicom_place(const fs::path& path, const VolumeChoice& choice) {
  std::vector<fs::path> files = {path};
  if (fs::is_directory(path)) files = dicom_files(path);
  if (!fs::exists(path)) files = matching_files(path);
  return open_dicom(path, files, choice);
}

StoredVolume open_zarr_place(const fs::path& path, const VolumeChoice& choice) {
  return open_zarr(path.string(), choice);
}

StoredVolume open_vtk_xml(const fs::path& path, const VolumeChoice& choice) {
  const std::string bytes = unpacked_beginning(InputFile(path), kSniffedBytes);
  const bool is_parallel = bytes.find("\"PImageData\"") != std::string::npos;
  return is_parallel ? open_pvti(path, choice) : open_vti(path, choice);
}

StoredVolume open_pictures(const fs::path& path, const VolumeChoice&) {
  return open_image_stack(path);
}

StoredVolume open_tiff_place(const fs::path& path, const VolumeChoice& choice) {
  return fs::is_regular_file(path) ? open_tiff(path, choice) : open_image_stack(path);
}

StoredVolume open_cube_file(const fs::path& path, const VolumeChoice&) { return open_cube(path); }

StoredVolume open_raw_samples(const fs::path& path, const VolumeChoice& choice) {
  if (is_raw_description(unpacked_beginning(InputFile(path), kSniffedBytes))) {
    return open_described(described_raw(path, choice.allow_external_files));
  }
  const std::optional<DescribedRaw> raw = layout_of_raw(path);
  if (!raw) fail_reading(path, "the layout of its samples is unknown", "Give it with --dims");
  StoredVolume volume = open_described(*raw);
  volume.notices.push_back("'" + path.string() + "': using the layout from " + raw->source + ".");
  return volume;
}

constexpr std::array kFormats = {
    VolumeFormat{.name = "NRRD",
                 .files = ".nrrd, .nhdr",
                 .notes = "raw, gzip, bzip2, text, hex; one data file, a list or a pattern; "
                          "--time, --component",
                 .open = open_nrrd,
                 .is_beginning = begins_nrrd,
                 .suffixes = ".nrrd .nhdr"},
    VolumeFormat{.name = "MetaImage",
                 .files = ".mha, .mhd",
                 .notes = "raw, zlib, text; one data file, a list or a pattern; --time, "
                          "--component",
                 .open = open_meta_image,
                 .is_beginning = begins_meta_image,
                 .suffixes = ".mha .mhd"},
    VolumeFormat{.name = "NIfTI 1 and 2, Analyze",
                 .files = ".nii, .nii.gz, .hdr, .img",
                 .notes = "all integers and floats, RGB; --time, --component",
                 .open = open_nifti,
                 .is_beginning = is_nifti,
                 .suffixes = ".nii .nii.gz"},
    VolumeFormat{.name = "MGH",
                 .files = ".mgh, .mgz",
                 .notes = "volumes of FreeSurfer; --time",
                 .open = open_mgh,
                 .is_beginning = is_mgh,
                 .suffixes = ".mgh .mgz"},
    VolumeFormat{.name = "DICOM",
                 .files = "a folder, a pattern, .dcm",
                 .notes = "slices, frames, mosaics, SEG (--label), parametric maps; all "
                          "compressions of GDCM; --series, --time, --resample",
                 .open = open_dicom_place,
                 .is_beginning = is_dicom,
                 .suffixes = ".dcm",
                 .has_series = true},
    VolumeFormat{
        .name = "OME-Zarr 0.1 to 0.6",
        .files = "a folder, .zip, http(s)://, s3://",
        .notes = "blosc, lz4, zstd, gzip, zlib, bz2; shards; --series, --level, --channel, --time",
        .open = open_zarr_place,
        .has_arrays = true,
        .has_levels = true},
    VolumeFormat{.name = "Zarr 2 and 3, N5",
                 .files = "a folder, http(s)://, s3://",
                 .notes = "the same codecs; --array",
                 .open = open_zarr_place,
                 .has_arrays = true,
                 .has_levels = true},
    VolumeFormat{.name = "VTK image data",
                 .files = ".vti, .pvti, .pvd",
                 .notes = "text, base64, appended; zlib, LZ4; --array",
                 .open = open_vtk_xml,
                 .is_beginning = begins_vtk_xml,
                 .suffixes = ".vti",
                 .has_arrays = true},
    VolumeFormat{.name = "legacy VTK",
                 .files = ".vtk",
                 .notes = "structured points, text or binary; --array, --component",
                 .open = open_legacy_vtk,
                 .is_beginning = begins_legacy_vtk,
                 .suffixes = ".vtk",
                 .has_arrays = true},
    VolumeFormat{.name = "TIFF",
                 .files = ".tif, .ome, a folder, a pattern",
                 .notes = "pages (plain, ImageJ, OME-TIFF, MetaMorph) or a file for each slice; "
                          "--series, --channel, --time, --component",
                 .open = open_tiff_place,
                 .is_beginning = begins_tiff,
                 .suffixes = ".tif .tiff .ome"},
    VolumeFormat{.name = "PNG, JPEG",
                 .files = ".png, .jpg, a folder, a pattern",
                 .notes = "a file for each slice; --component",
                 .open = open_pictures,
                 .is_beginning = begins_picture,
                 .suffixes = ".png .jpg .jpeg"},
    VolumeFormat{.name = "HDF5",
                 .files = ".h5:/path, .mnc, .vtkhdf, .nxs, .emd",
                 .notes = "plain, MINC 2, VTKHDF, NXdata, EMD, openPMD, axistags, BigDataViewer, "
                          "DREAM.3D, ITK; the filters of libhdf5, and LZF; --time, --channel",
                 .open = open_hdf5,
                 .is_beginning = is_hdf5,
                 .suffixes = ".h5 .hdf5 .nc",
                 .has_arrays = true,
                 .has_levels = true},
    VolumeFormat{.name = "Imaris",
                 .files = ".ims",
                 .notes = "--level, --time, --channel",
                 .open = open_hdf5,
                 .suffixes = ".ims",
                 .has_arrays = true,
                 .has_levels = true},
    VolumeFormat{.name = "BigDataViewer",
                 .files = ".xml",
                 .notes =
                     "HDF5 and N5 that the XML leads to, placed by its registrations; --series, "
                     "--level, --time",
                 .open = open_bdv,
                 .is_beginning = is_bdv_xml,
                 .has_arrays = true,
                 .has_levels = true,
                 .has_series = true},
    VolumeFormat{.name = "NetCDF 3 and 4",
                 .files = ".nc, .nc:/name",
                 .notes = "CF, MINC 1; --time, --channel",
                 .open = open_netcdf,
                 .is_beginning = is_classic_netcdf,
                 .has_arrays = true},
    VolumeFormat{.name = "NumPy",
                 .files = ".npy, .npz",
                 .notes = "2 to 5 dimensions; --array, --time, --channel",
                 .open = open_npy,
                 .is_beginning = is_npy,
                 .suffixes = ".npy .npz",
                 .has_arrays = true},
    VolumeFormat{.name = "MRC and CCP4",
                 .files = ".mrc, .map, .ccp4",
                 .notes = "modes 0, 1, 2, 6, 12; also gzipped; stacks of volumes (--time); the "
                          "contour level of an EMDB header beside it",
                 .open = open_mrc,
                 .is_beginning = is_mrc,
                 .suffixes = ".mrc .ccp4"},
    VolumeFormat{.name = "cube",
                 .files = ".cube, .cub",
                 .notes = "densities and orbitals; also gzipped; --component",
                 .open = open_cube_file,
                 .is_beginning = is_cube,
                 .suffixes = ".cube .cub .cube.gz .cub.gz"},
    VolumeFormat{.name = "raw",
                 .files = ".raw, .raw.gz, .dat",
                 .notes = "with --dims; or described by a .dat or .txt beside it, three leading "
                          "counts, or its name (_64x64x64_uint8.raw)",
                 .open = open_raw_samples,
                 .is_beginning = is_raw_description,
                 .is_described = true},
};

const VolumeFormat& format_with(decltype(VolumeFormat::open) open) {
  return *std::find_if(kFormats.begin(), kFormats.end(),
                       [&](const VolumeFormat& format) { return format.open == open; });
}

std::string lower_case_name_of(const fs::path& file) {
  return lower_case(file.filename().string());
}

bool has_suffix_of(const VolumeFormat& format, std::string_view name) {
  std::string_view rest = format.suffixes;
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(' '), rest.size());
    if (name.ends_with(rest.substr(0, end))) return true;
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return false;
}

const VolumeFormat* format_of_folder(const fs::path& folder) {
  if (is_zarr(folder.string(), /*follow=*/true)) return &format_with(open_zarr_place);
  const VolumeFormat& tiff = format_with(open_tiff_place);
  const VolumeFormat& pictures = format_with(open_pictures);
  std::error_code error;
  bool has_tiff = false;
  bool has_picture = false;
  bool has_dicom = false;  // Directly in this folder: those below may belong to several volumes.
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string name = lower_case_name_of(entry->path());
    has_tiff = has_tiff || has_suffix_of(tiff, name);
    has_picture = has_picture || has_suffix_of(pictures, name);
    std::error_code ignored;
    has_dicom = has_dicom || name == "dicomdir" ||
                (entry->is_regular_file(ignored) && !name.starts_with('.') &&
                 is_dicom(InputFile(entry->path()).beginning(kDicomBeginning)));
  }
  if (has_tiff) return &tiff;
  if (has_dicom) return &format_with(open_dicom_place);
  return has_picture ? &pictures : nullptr;
}

}  // namespace

std::span<const VolumeFormat> volume_formats() { return kFormats; }

const VolumeFormat* recognized_format(const fs::path& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) return format_of_folder(path);
  const InputFile file(path);
  const std::string bytes = unpacked_beginning(file, kSniffedBytes);
  if (is_zip(bytes) && is_zarr(path.string(), /*follow=*/false)) {
    return &format_with(open_zarr_place);
  }
  for (const VolumeFormat& format : kFormats) {
    if (format.is_beginning != nullptr && format.is_beginning(bytes)) return &format;
  }
  if (nifti_header_of(path)) return &format_with(open_nifti);
  const std::string name = lower_case_name_of(path);
  for (const VolumeFormat& format : kFormats) {
    if (has_suffix_of(format, name)) return &format;
  }
  return layout_of_raw(path) ? &format_with(open_raw_samples) : nullptr;
}

const VolumeFormat& format_of_pattern(const fs::path& pattern) {
  const std::vector<fs::path> files = matching_files(pattern);
  const bool are_dicom = std::any_of(files.begin(), files.end(), [](const fs::path& file) {
    return is_dicom(OpenFile(file).content(kDicomBeginning).value_or(""));
  });
  return are_dicom ? format_with(open_dicom_place) : format_with(open_pictures);
}

const VolumeFormat& format_of_addresses() { return format_with(open_zarr_place); }

}  // namespace multitetra
