// One volume in every format, written by write_volumes.py, gives one dataset.
#include <gtest/gtest.h>

#include <array>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "server/volume/volume_files.hpp"
#include "tests/support/folder_server.hpp"
#include "tests/support/temporary_folder.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

struct WrittenFormat {
  std::string name;
  fs::path path;
};

// Writes one file per format into `folder` and returns them. Prints a warning for missing packages.
std::vector<WrittenFormat> written_formats(const fs::path& folder) {
  // Written once for all tests of this process.
  static const TemporaryFolder all;
  const fs::path list = all.path() / "list.txt";
  if (!fs::exists(list)) {
    const std::string command = std::string(MULTITETRA_PYTHON) + " " + MULTITETRA_VOLUME_SCRIPTS +
                                "/write_volumes.py " + all.path().string() + " > " + list.string();
    if (std::system(command.c_str()) != 0) {
      EXPECT_NE(std::system(MULTITETRA_PYTHON " -c 'import numpy'"), 0) << command;
      return {};
    }
  }
  fs::copy(all.path(), folder, fs::copy_options::recursive | fs::copy_options::copy_symlinks);
  std::vector<WrittenFormat> formats;
  std::ifstream in(list);
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    WrittenFormat format;
    std::string path;
    words >> format.name >> path;
    format.path = folder / fs::path(path).lexically_relative(all.path());
    if (format.name == "missing") {
      std::cerr << "NOT TESTED: formats that need the Python package " << path << "\n";
    } else {
      formats.push_back(format);
    }
  }
  return formats;
}

VolumeChoice choice_for(const std::string& name) {
  VolumeChoice choice;
  if (name == "zarr-2-time-1-channel-2") {
    choice.time = 1;
    choice.channel = 2;
  }
  return choice;
}

// Returns whether the format stores origin and spacing.
bool has_origin(const std::string& name) {
  return !name.starts_with("n5") && !name.starts_with("raw") && !name.starts_with("tiff");
}
bool has_spacing(const std::string& name) {
  return name != "raw-gzip" && name != "tiff-pages" && name != "tiff-stack";
}

std::string unit_named_in(const std::string& name) {
  if (name.starts_with("zarr") || name.starts_with("n5") || name.starts_with("nifti")) return "µm";
  if (name.starts_with("tiff-ome")) return "µm";
  if (name.starts_with("mrc")) return "Å";
  if (name == "hdf5") return "m";
  return name.starts_with("dicom") ? "mm" : "";
}

TEST(VolumeFormats, ReadTheSameSamplesAndPlacement) {
  const TemporaryFolder folder;
  const std::vector<WrittenFormat> formats = written_formats(folder.path());
  if (formats.empty()) GTEST_SKIP() << "NOT TESTED: there is no Python with numpy";
  ASSERT_EQ(formats.front().name, "nrrd");
  const Volume expected = read_volume(formats.front().path);
  ASSERT_EQ(expected.dims, (std::array<std::int32_t, 3>{24, 20, 12}));
  ASSERT_EQ(expected.type(), SampleType::kI16);
  for (const auto& [name, path] : formats) {
    SCOPED_TRACE(name);
    const auto source = open_volume(path, {.choice = choice_for(name)});
    const VolumeHeader header = source->header();
    EXPECT_EQ(header.dims, expected.dims);
    EXPECT_EQ(header.meaning.length_unit, unit_named_in(name));
    EXPECT_EQ(source->take_all(), expected.samples);
    if (!has_spacing(name)) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(header.spacing[axis], expected.spacing[axis], 1e-6);
      const double origin = has_origin(name) ? expected.index_to_world.translation[axis] : 0;
      EXPECT_NEAR(header.index_to_world.translation[axis], origin, 1e-5);
    }
  }
  EXPECT_GE(formats.size(), 20u);
}

TEST(VolumeFormats, ReadLayersBackwards) {
  const TemporaryFolder folder;
  const std::vector<WrittenFormat> formats = written_formats(folder.path());
  if (formats.empty()) GTEST_SKIP() << "NOT TESTED: there is no Python with numpy";
  const Volume expected = read_volume(formats.front().path);
  const auto& all = std::get<std::vector<std::int16_t>>(expected.samples);
  for (const auto& [name, path] : formats) {
    SCOPED_TRACE(name);
    const auto source = open_volume(path, {.choice = choice_for(name)});
    Samples slab;
    for (const std::int32_t first : {10, 7, 3, 0}) {
      source->read(first, 2, slab);
      EXPECT_EQ(slab, Samples(std::vector<std::int16_t>(all.begin() + 480 * first,
                                                        all.begin() + 480 * (first + 2))));
    }
  }
}

TEST(VolumeFormats, ReadChannelsOfImageJHyperstacks) {
  const TemporaryFolder folder;
  const std::vector<WrittenFormat> formats = written_formats(folder.path());
  const fs::path file = folder.path() / "imagej.tif";
  if (!fs::exists(file)) GTEST_SKIP() << "NOT TESTED: there is no Python with tifffile";
  const Volume expected = read_volume(formats.front().path);
  const auto& all = std::get<std::vector<std::int16_t>>(expected.samples);
  for (const int channel : {0, 1}) {
    const Volume volume = read_volume(file, {.choice = {.channel = channel}});
    EXPECT_EQ(volume.dims, expected.dims);
    EXPECT_EQ(volume.meaning.length_unit, "µm");
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(volume.spacing[axis], expected.spacing[axis], 1e-6);
    }
    const auto& samples = std::get<std::vector<float>>(volume.samples);
    for (std::size_t i = 0; i < all.size(); ++i) {
      ASSERT_EQ(samples[i], static_cast<float>(all[i] + channel)) << i;
    }
  }
}

TEST(VolumeFormats, AcceptObliqueAndRejectShearedSlices) {
  const TemporaryFolder folder;
  (void)written_formats(folder.path());
  if (!fs::exists(folder.path() / "oblique")) {
    GTEST_SKIP() << "NOT TESTED: there is no Python with pydicom";
  }
  const Affine place = read_volume(folder.path() / "oblique").index_to_world;
  const std::array<Vec3, 3> steps = {{{0.18, -0.4, 0.24}, {0.36, 0.45, 0.48}, {-1.6, 0, 1.2}}};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t row = 0; row < 3; ++row) {
      EXPECT_NEAR(place.columns[axis][row], steps[axis][row], 1e-6);
    }
  }
  EXPECT_NEAR(place.translation[2], 30, 1e-6);
  try {
    (void)read_volume(folder.path() / "tilted");
    ADD_FAILURE() << "a tilted gantry is taken for a rectangular grid";
  } catch (const VolumeFileError& problem) {
    EXPECT_NE(std::string(problem.what()).find("tilted gantry"), std::string::npos);
  }
}

// ---- over the network

TEST(VolumeFormats, ReadHttpAndSignedBuckets) {
  const TemporaryFolder folder;
  const std::vector<WrittenFormat> formats = written_formats(folder.path());
  if (formats.empty()) GTEST_SKIP() << "NOT TESTED: there is no Python with numpy";
  const Volume expected = read_volume(formats.front().path);
  const FolderServer server(folder.path());
  ASSERT_FALSE(server.address().empty());
  setenv("AWS_ENDPOINT_URL", (server.address() + "/s3").c_str(), 1);
  int read = 0;
  for (const auto& [name, path] : formats) {
    if (!name.starts_with("zarr") && !name.starts_with("n5")) continue;
    SCOPED_TRACE(name);
    const std::string file = path.filename().string();
    const VolumeFileOptions options{.choice = choice_for(name)};
    EXPECT_EQ(read_volume(server.address() + "/" + file, options).samples, expected.samples);
    setenv("AWS_ACCESS_KEY_ID", "reader", 1);
    setenv("AWS_SECRET_ACCESS_KEY", "a secret", 1);
    EXPECT_EQ(read_volume("s3://volumes/" + file, options).samples, expected.samples);
    setenv("AWS_SECRET_ACCESS_KEY", "another one", 1);
    EXPECT_THROW((void)read_volume("s3://volumes/" + file, options), VolumeFileError);
    ++read;
  }
  // An image whose level lies beside it.
  fs::create_directory(folder.path() / "image.zarr");
  std::ofstream(folder.path() / "image.zarr/.zattrs") << R"({"multiscales": [{"axes": [
      {"name": "z"}, {"name": "y"}, {"name": "x"}], "datasets": [{"path": "../elsewhere.zarr",
      "coordinateTransformations": [{"type": "scale", "scale": [1, 1, 1]}]}]}]})";
  setenv("AWS_SECRET_ACCESS_KEY", "a secret", 1);
  for (const std::string& place :
       {server.address() + "/image.zarr", std::string("s3://volumes/image.zarr")}) {
    try {
      (void)read_volume(place);
      ADD_FAILURE() << place << " leads out of the store";
    } catch (const VolumeFileError& problem) {
      EXPECT_NE(std::string(problem.what()).find("--follow"), std::string::npos) << problem.what();
    }
  }
  unsetenv("AWS_ACCESS_KEY_ID");
  EXPECT_GE(read, 7);
  for (const std::string wrong : {"/nothing", "/sharded-end.zarr/s0/c"}) {
    EXPECT_THROW((void)read_volume(server.address() + wrong), VolumeFileError) << wrong;
  }
}

// Chunks that a store forbids do not count as missing.
TEST(VolumeFormats, RejectPartlyForbiddenStores) {
  const TemporaryFolder folder;
  const std::vector<WrittenFormat> formats = written_formats(folder.path());
  if (formats.empty()) GTEST_SKIP() << "NOT TESTED: there is no Python with numpy";
  const fs::path chunk = folder.path() / "gzip.n5/1/1/1";
  ASSERT_TRUE(fs::exists(chunk));
  const FolderServer server(folder.path());
  ASSERT_FALSE(server.address().empty());
  for (const char* status : {"401", "403"}) {
    // The metadata are readable; then every path fails independently.
    const std::string lies = std::string("/lies/") + status + "-blocks/1000/";
    try {
      (void)read_volume(server.address() + lies + "gzip.n5");
      ADD_FAILURE() << status;
    } catch (const VolumeFileError& problem) {
      EXPECT_NE(std::string(problem.what()).find(std::string("status ") + status),
                std::string::npos)
          << problem.what();
    }
  }
  fs::remove(chunk);
  std::string notices;
  (void)read_volume(server.address() + "/gzip.n5",
                    {.notice = [&](const std::string& text) { notices += text; }});
  EXPECT_NE(notices.find("1 of 27 chunks are missing"), std::string::npos) << notices;
}

TEST(VolumeFormats, OmitPasswordsFromErrors) {
  const TemporaryFolder folder;
  const FolderServer server(folder.path());
  ASSERT_FALSE(server.address().empty());
  const std::string host = server.address().substr(7);
  try {
    (void)read_volume("http://reader:hidden@" + host + "/nothing");
    ADD_FAILURE();
  } catch (const VolumeFileError& problem) {
    EXPECT_EQ(std::string(problem.what()).find("hidden"), std::string::npos) << problem.what();
  }
}

// A whole file in place of a requested range must not be read as the range.
TEST(VolumeFormats, RejectServersWithoutRanges) {
  const TemporaryFolder folder;
  const std::vector<WrittenFormat> formats = written_formats(folder.path());
  if (formats.empty()) GTEST_SKIP() << "NOT TESTED: there is no Python with numpy";
  const FolderServer server(folder.path());
  ASSERT_FALSE(server.address().empty());
  int refused = 0;
  for (const auto& [name, path] : formats) {
    if (name.find("sharded") == std::string::npos) continue;
    const std::string address = server.address() + "/whole/" + path.filename().string();
    try {
      (void)read_volume(address, {.choice = choice_for(name)});
      ADD_FAILURE() << name;
    } catch (const VolumeFileError& problem) {
      EXPECT_NE(std::string(problem.what()).find("ranges"), std::string::npos) << problem.what();
    }
    ++refused;
  }
  EXPECT_GE(refused, 1);
}

}  // namespace
}  // namespace multitetra
