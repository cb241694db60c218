#include "server/volume/formats/recognition.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <string>

#include "common/base/text.hpp"
#include "server/volume/formats/cube_file.hpp"
#include "server/volume/formats/described_raw.hpp"
#include "server/volume/formats/detail/header_bytes.hpp"
#include "server/volume/formats/detail/input_file.hpp"
#include "server/volume/formats/detail/zip_store.hpp"
#include "server/volume/formats/dicom/dicom_series.hpp"
#include "server/volume/formats/hdf5/hdf5_file.hpp"
#include "server/volume/formats/mgh_file.hpp"
#include "server/volume/formats/mrc_file.hpp"
#include "server/volume/formats/netcdf_file.hpp"
#include "server/volume/formats/nifti_file.hpp"
#include "server/volume/formats/npy_file.hpp"
#include "server/volume/formats/zarr/zarr_volume.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kSniffedBytes = 4096;

constexpr std::array kFormats = {
    FormatDescription{"NRRD", ".nrrd, .nhdr",
                      "raw, gzip, bzip2, text, hex; one data file, a list or a pattern; --time, "
                      "--component"},
    FormatDescription{"MetaImage", ".mha, .mhd",
                      "raw, zlib, text; one data file, a list or a pattern; --time, --component"},
    FormatDescription{"NIfTI 1 and 2, Analyze", ".nii, .nii.gz, .hdr, .img",
                      "all integers and floats, RGB; --time, --component"},
    FormatDescription{"MGH", ".mgh, .mgz", "volumes of FreeSurfer; --time"},
    FormatDescription{
        "DICOM", "a folder, a pattern, .dcm",
        "slices, frames, mosaics, SEG (--label), parametric maps; all compressions of GDCM; "
        "--series, --time, --resample"},
    FormatDescription{"OME-Zarr 0.1 to 0.6", "a folder, .zip, http(s)://, s3://",
                      "blosc, lz4, zstd, gzip, zlib, bz2; shards; --level, --channel, --time"},
    FormatDescription{"Zarr 2 and 3, N5", "a folder, http(s)://, s3://",
                      "the same codecs; --array"},
    FormatDescription{"VTK image data", ".vti, .pvti, .pvd",
                      "text, base64, appended; zlib, LZ4; --array"},
    FormatDescription{"legacy VTK", ".vtk",
                      "structured points, text or binary; --array, --component"},
    FormatDescription{"TIFF", ".tif, a folder, a pattern",
                      "pages (plain, ImageJ, OME-TIFF, MetaMorph) or a file for each slice; "
                      "--series, --channel, --time, --component"},
    FormatDescription{"PNG, JPEG", ".png, .jpg, a folder, a pattern",
                      "a file for each slice; --component"},
    FormatDescription{"HDF5", ".h5:/path, .mnc, .vtkhdf, .nxs, .emd",
                      "plain, MINC 2, VTKHDF, NXdata, EMD, openPMD, axistags, BigDataViewer, "
                      "DREAM.3D; the filters of libhdf5, and LZF; --time, --channel"},
    FormatDescription{"Imaris", ".ims", "--level, --time, --channel"},
    FormatDescription{"NetCDF 3 and 4", ".nc, .nc:/name", "CF, MINC 1; --time, --channel"},
    FormatDescription{"NumPy", ".npy", "2 to 4 dimensions; --time"},
    FormatDescription{
        "MRC and CCP4", ".mrc, .map, .ccp4",
        "modes 0, 1, 2, 6, 12; also gzipped; stacks of volumes (--time); the contour level of an "
        "EMDB header beside it"},
    FormatDescription{"cube", ".cube, .cub", "densities and orbitals; also gzipped; --component"},
    FormatDescription{"raw", ".raw, .raw.gz, .dat",
                      "with --dims; or described by a .dat or .txt beside it, three leading "
                      "counts, or its name (_64x64x64_uint8.raw)"},
};

std::string lower_case_name_of(const fs::path& file) {
  return lower_case(file.filename().string());
}

bool starts_tiff(std::string_view bytes) {
  using namespace std::string_view_literals;
  return bytes.starts_with("II*\0"sv) || bytes.starts_with("MM\0*"sv) ||
         bytes.starts_with("II+\0"sv) || bytes.starts_with("MM\0+"sv);
}

bool starts_vti(std::string_view bytes) {
  return bytes.starts_with("<VTKFile") ||
         (bytes.starts_with("<?xml") && bytes.find("<VTKFile") != std::string_view::npos);
}

bool starts_meta_image(std::string_view bytes) {
  return bytes.starts_with("ObjectType") || bytes.starts_with("NDims") ||
         (bytes.starts_with("Comment") && bytes.find("NDims") != std::string_view::npos);
}

std::optional<VolumeFormat> by_content(std::string_view bytes) {
  if (bytes.starts_with("NRRD000")) return VolumeFormat::kNrrd;
  if (bytes.starts_with("# vtk DataFile")) return VolumeFormat::kLegacyVtk;
  if (starts_vti(bytes)) {
    const bool is_parallel = bytes.find("\"PImageData\"") != std::string_view::npos;
    return is_parallel ? VolumeFormat::kPvti : VolumeFormat::kVti;
  }
  if (is_hdf5(bytes)) return VolumeFormat::kHdf5;
  if (is_classic_netcdf(bytes)) return VolumeFormat::kNetcdf;
  if (is_npy(bytes)) return VolumeFormat::kNpy;
  if (is_dicom(bytes)) return VolumeFormat::kDicom;
  if (is_nifti(bytes)) return VolumeFormat::kNifti;
  if (is_mrc(bytes)) return VolumeFormat::kMrc;
  if (starts_tiff(bytes)) return VolumeFormat::kTiff;
  if (bytes.starts_with("\x89PNG") || bytes.starts_with("\xFF\xD8\xFF")) {
    return VolumeFormat::kImageStack;
  }
  if (is_mgh(bytes)) return VolumeFormat::kMgh;
  if (is_raw_description(bytes)) return VolumeFormat::kRawDescription;
  if (starts_meta_image(bytes)) return VolumeFormat::kMetaImage;
  return std::nullopt;
}

// Returns the format by name for unknown content; the reader then reports the error.
std::optional<VolumeFormat> by_name(const std::string& name) {
  const auto ends_with = [&](auto... suffixes) { return (name.ends_with(suffixes) || ...); };
  if (ends_with(".nrrd", ".nhdr")) return VolumeFormat::kNrrd;
  if (ends_with(".mha", ".mhd")) return VolumeFormat::kMetaImage;
  if (ends_with(".nii", ".nii.gz")) return VolumeFormat::kNifti;
  if (ends_with(".mgh", ".mgz")) return VolumeFormat::kMgh;
  if (ends_with(".npy")) return VolumeFormat::kNpy;
  if (ends_with(".vtk")) return VolumeFormat::kLegacyVtk;
  if (ends_with(".vti")) return VolumeFormat::kVti;
  if (ends_with(".tif", ".tiff")) return VolumeFormat::kTiff;
  if (ends_with(".png", ".jpg", ".jpeg")) return VolumeFormat::kImageStack;
  if (ends_with(".h5", ".hdf5", ".nc")) return VolumeFormat::kHdf5;
  if (ends_with(".dcm")) return VolumeFormat::kDicom;
  if (ends_with(".mrc", ".ccp4")) return VolumeFormat::kMrc;
  if (ends_with(".cube", ".cub", ".cube.gz", ".cub.gz")) return VolumeFormat::kCube;
  return std::nullopt;
}

std::optional<VolumeFormat> format_of_folder(const fs::path& folder) {
  if (is_zarr(folder.string(), /*follow=*/true)) return VolumeFormat::kZarr;
  std::error_code error;
  bool has_tiff = false;
  bool has_picture = false;  // PNG or JPEG.
  bool has_dicom = false;    // Directly in this folder: those below may belong to several volumes.
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string name = lower_case_name_of(entry->path());
    has_tiff = has_tiff || name.ends_with(".tif") || name.ends_with(".tiff");
    has_picture =
        has_picture || name.ends_with(".png") || name.ends_with(".jpg") || name.ends_with(".jpeg");
    std::error_code ignored;
    has_dicom = has_dicom || name == "dicomdir" ||
                (entry->is_regular_file(ignored) && !name.starts_with('.') &&
                 is_dicom(InputFile(entry->path()).beginning(132)));
  }
  if (has_tiff) return VolumeFormat::kImageStack;
  if (has_dicom) return VolumeFormat::kDicom;
  if (has_picture) return VolumeFormat::kImageStack;
  return std::nullopt;
}

}  // namespace

std::optional<VolumeFormat> recognized_format(const fs::path& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) return format_of_folder(path);
  const InputFile file(path);
  const std::string bytes = unpacked_beginning(file, kSniffedBytes);
  if (is_zip(bytes) && is_zarr(path.string(), /*follow=*/false)) {
    return VolumeFormat::kZarr;
  }
  if (const auto format = by_content(bytes)) return format;
  if (nifti_header_of(path)) return VolumeFormat::kNifti;
  const std::string name = lower_case_name_of(path);
  if (const auto format = by_name(name)) return format;
  if (is_cube(bytes)) return VolumeFormat::kCube;
  if (layout_of_raw(path)) return VolumeFormat::kRaw;
  return std::nullopt;
}

std::span<const FormatDescription> known_formats() { return kFormats; }

}  // namespace multitetra
