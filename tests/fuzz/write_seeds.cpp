// Writes the initial inputs for fuzzing: valid messages, frames, tiles and datasets.
//   write_seeds DIRECTORY    fills DIRECTORY/<harness>/
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <zlib.h>

#include "client/library/tile_disk_cache.hpp"
#include "common/base/number_text.hpp"
#include "common/net/frame.hpp"
#include "common/sandbox/isolation.hpp"
#include "common/sandbox/packed.hpp"
#include "common/wire/lattice_glb.hpp"
#include "common/wire/mesh_files.hpp"
#include "common/wire/messages.hpp"
#include "server/dataset/prepare.hpp"
#include "server/volume/detail/reader_messages.hpp"
#include "tests/fuzz/dataset_file_input.hpp"
#include "tests/server/volume/written_volumes.hpp"
#include "tests/support/fields.hpp"
#include "tests/support/sample_messages.hpp"
#include "tests/support/surfaces.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/volume_in_memory.hpp"

namespace {

using namespace multitetra;

void write(const std::filesystem::path& folder, int number, const std::string& bytes) {
  std::filesystem::create_directories(folder);
  write_file(folder / ("seed" + std::to_string(number)), bytes);
}

std::string framed(const std::string& content) {
  return frame_header(static_cast<std::uint32_t>(content.size())) + content;
}

// In the format of fuzz_tile.cpp.
std::string promised_tile(const LatticeMesh& mesh, int speed, int normal_bits = 0) {
  std::vector<UnitVector> directions;
  for (std::size_t i = 0; normal_bits != 0 && i < mesh.vertices.size(); ++i) {
    const auto angle = 0.1F * static_cast<float>(i);
    directions.push_back({std::cos(angle), 0, std::sin(angle)});
  }
  const EncodedTile tile =
      encode_tile(mesh, {15, 0, 0, 0}, speed, {.directions = directions, .bits = normal_bits});
  std::string bytes(21, '\0');
  if (normal_bits != 0) bytes.back() = static_cast<char>(normal_bits - 7);
  std::memcpy(bytes.data(), &tile.summary.digest, 16);
  std::memcpy(bytes.data() + 16, &tile.summary.vertices, 4);
  return bytes + *tile.payload;
}

void write_whole_datasets(const std::filesystem::path& folder) {
  const TemporaryFolder prepared;
  int number = 0;
  const auto add = [&](Volume volume, std::optional<double> outside, bool samples_only) {
    const auto file = prepared.path() / "whole.mtd";
    prepare(*source_of(std::move(volume)),
            {.name = "whole", .outside = outside, .bins = 4, .samples_only = samples_only}, file,
            {});
    write(folder, ++number, input_of_sections(bytes_of_file(file)));
  };
  for (const bool samples_only : {false, true}) {
    add(testing::fields::gyroid(11, 0.3, 8), std::nullopt, samples_only);
    add(testing::fields::integer_noise({12, 9, 14}, 50, 6), 30.5, samples_only);
    add(testing::fields::masked_gyroid(12, 10), std::nullopt, samples_only);
  }
}

// In the format of fuzz_sandbox_answer.cpp.
void write_sandbox_answers(const std::filesystem::path& folder) {
  VolumeHeader header{.dims = {3, 4, 5}};
  header.values = "as stored";
  write(folder, 1, "h" + header_text(header));
  VolumeContents contents;
  contents.times = even_times(3, 0, 0.5, "s");
  contents.fields = {{.name = "density", .array = "density", .components = 3, .color = 0xFF8000}};
  contents.labels = {{.label = {.value = 3, .name = "liver", .color = 0x123456}, .stored = 3}};
  contents.entries = {
      {.kind = "array", .name = "density", .detail = "3 x 4", .option = "--array density"}};
  contents.recommended_isovalue = 0.5;
  contents.display_window = DisplayWindow{.low = -1, .high = 2};
  write(folder, 2, "c" + contents_text(contents));
  std::string labels("\x01\0\0\0\0\0\0\0", 8);
  labels += packed_values(3.0, std::string("liver"), std::optional<std::uint32_t>(7));
  write(folder, 3, "a" + labels);
  write(folder, 4, "a" + packed_values(std::uint64_t{1}, std::string("a.vti"), 0.5));
  SandboxRules rules{.readable = {"/data", "/data/a.nrrd"}, .network = true};
  write(folder, 5, "r" + packed_values(rules));
  const auto message = [](char kind, const std::string& bytes) {
    return kind + packed_values(bytes);
  };
  write(folder, 6,
        "x" + message('n', "a notice") + message('s', std::string(16, 's')) +
            message('k', packed_values(std::uint64_t{4})) + message('f', ""));
}

// In the format of fuzz_dataset_pages.cpp.
template <typename Random>
void write_dataset_pages(const std::filesystem::path& folder, Random& random) {
  for (int number = 1; number <= 4; ++number) {
    std::string input;
    for (int page = 1; page <= number; ++page) {
      DatasetList list{.request_id = 1};
      for (int i = 0; i < 2; ++i) {
        list.datasets.push_back(samples::dataset_info(random));
        list.datasets.back().name = "head-" + std::to_string(2 * page + i);
      }
      if (page < number) list.next = list.datasets.back().name;
      const std::string message = serialize(ServerMessage(list));
      const auto size = static_cast<std::uint16_t>(message.size());
      input.append(reinterpret_cast<const char*>(&size), sizeof(size));
      input += message;
    }
    write(folder, number, input);
  }
}

// In the format of fuzz_volume_metadata.cpp.
void write_volume_metadata(const std::filesystem::path& folder) {
  const std::string vti =
      R"(<?xml version="1.0"?><VTKFile type="ImageData" byte_order="LittleEndian" header_type="UInt32")"
      R"( compressor="vtkZLibDataCompressor"><ImageData WholeExtent="0 3 0 2 0 1" Origin="1 2 3")"
      R"( Spacing="1 1 2" Direction="1 0 0 0 1 0 0 0 1"><Piece Extent="0 3 0 2 0 1">)"
      R"(<PointData Scalars="a"><DataArray type="Int16" Name="a" NumberOfComponents="1" format="ascii">)"
      R"(1 2 3</DataArray><DataArray type="Float64" Name="b" format="appended" offset="0"/></PointData>)"
      R"(</Piece></ImageData><AppendedData encoding="raw">_xxxx</AppendedData></VTKFile>)";
  write(folder, 1, std::string(1, '\0') + vti);
  write(folder, 2, std::string(1, '\1') + vti);
  const std::string numbers(16, '\7');
  write(folder, 3,
        std::string(1, '\2') +
            R"({"zarr_format":2,"shape":[5,6],"chunks":[2,4],"dtype":"<i2","compressor":null,)"
            R"("fill_value":-1,"filters":null,"order":"F","dimension_separator":"/"})" +
            '\0' + numbers);
  write(folder, 4,
        std::string(1, '\2') +
            R"({"zarr_format":2,"shape":[5],"chunks":[2],"dtype":">f8","compressor":{"id":"zlib"},)"
            R"("fill_value":"NaN","filters":[],"order":"C"})" +
            '\0' + numbers);
  const std::string three =
      R"({"zarr_format":3,"node_type":"array","shape":[8,8],"data_type":"uint16","fill_value":0,)"
      R"("chunk_grid":{"name":"regular","configuration":{"chunk_shape":[4,2]}},)"
      R"("chunk_key_encoding":{"name":"default"},"dimension_names":["y","x"],"codecs":[)";
  write(folder, 5,
        std::string(1, '\3') + three +
            R"({"name":"transpose","configuration":{"order":[1,0]}},{"name":"bytes"}]})" + '\0' +
            numbers);
  write(
      folder, 6,
      std::string(1, '\3') + three +
          R"({"name":"sharding_indexed","configuration":{"chunk_shape":[2,2],"codecs":[{"name":"bytes"},)"
          R"({"name":"gzip"}],"index_codecs":[{"name":"bytes"},{"name":"crc32c"}]}}]})" +
          '\0' + numbers);
  write(
      folder, 7,
      std::string(1, '\4') +
          R"({"dimensions":[5,6],"blockSize":[2,4],"dataType":"int16","compression":{"type":"raw"}})" +
          '\0' + std::string("\0\0\0\2\0\0\0\2\0\0\0\4", 12) + numbers);
  write(folder, 8,
        "\5ImageJ=1.53t\nimages=12\nchannels=2\nslices=3\nframes=2\nunit=micron\nspacing=2.5\n"
        "finterval=0.5\n");
  write(folder, 9,
        "\6<OME><Image><Pixels DimensionOrder=\"XYCZT\" SizeZ=\"3\" SizeC=\"2\" SizeT=\"1\" "
        "PhysicalSizeX=\"0.2\"><Channel Name=\"a\"/><TiffData IFD=\"3\" FirstZ=\"1\" "
        "PlaneCount=\"3\"/></Pixels></Image></OME>");
}

// In the format of fuzz_volume_file.cpp: 4 x 3 x 2 samples in each file format.
void write_volume_files(const std::filesystem::path& folder) {
  const std::vector<double> numbers = values();
  const std::string shorts = packed<std::int16_t>(numbers);
  int number = 0;
  const auto add = [&](int format, const std::string& bytes) {
    write(folder, ++number, std::string(1, static_cast<char>(format)) + bytes);
  };
  for (const int format : {0, 1}) {
    add(format, nifti({4, 16}, shorts, Endian::kLittle));
    add(format, nifti({16, 32}, packed<float>(numbers, Endian::kBig), Endian::kBig, {2, -1}));
    add(format, nifti({2, 8}, packed<std::uint8_t>(numbers) + packed<std::uint8_t>(numbers),
                      Endian::kLittle, {1, 0}, {2, 1}));
  }
  std::string map(1024, '\0');
  const auto put = [&map](std::size_t word, const std::string& bytes) {
    map.replace(4 * word, bytes.size(), bytes);
  };
  put(0, packed<std::int32_t>({4, 3, 2, 1, 0, 0, 0, 4, 3, 2}));  // Counts, mode, start, intervals.
  put(10, packed<float>({8, 6, 4, 90, 90, 90}));                 // The cell.
  put(16, packed<std::int32_t>({1, 2, 3}));                      // Columns, rows, sections.
  put(52, "MAP ");
  put(53, std::string("\x44\x44\0\0", 4));
  for (const int format : {2, 3}) add(format, map + shorts);
  std::string cube =
      "by hand\nfor a fuzzer\n 1 0.0 0.0 0.0\n 2 0.5 0.0 0.0\n 3 0.0 0.5 0.0\n"
      " 4 0.0 0.0 0.5\n 6 6.0 0.1 0.2 0.3\n";
  for (const double value : numbers) cube += " " + std::to_string(value);
  add(4, cube + "\n");
  const auto vti = [](const std::string& format, const std::string& content) {
    return R"(<VTKFile type="ImageData" byte_order="LittleEndian" header_type="UInt32">)"
           R"(<ImageData WholeExtent="0 3 0 2 0 1" Spacing="1 1 2"><Piece Extent="0 3 0 2 0 1">)"
           R"(<PointData Scalars="a"><DataArray type="Int16" Name="a" format=")" +
           format + "/></PointData></Piece></ImageData>" + content + "</VTKFile>";
  };
  std::string text;
  for (const double value : numbers) text += shortest_text(value) + " ";
  const std::string inside = vti("ascii\"", "");
  add(5, inside.substr(0, inside.find("/></PointData>")) + ">" + text + "</DataArray>" +
             inside.substr(inside.find("</PointData>")));
  add(5,
      vti("appended\" offset=\"0\"", "<AppendedData encoding=\"raw\">_" +
                                         packed<std::uint32_t>({48}) + shorts + "</AppendedData>"));
  add(6, "ObjectFileName: v.raw\nResolution: 4 4 2\nSliceThickness: 1 1 2\nFormat: USHORT\n");
  add(7, packed<std::uint16_t>({4, 3, 2}) + shorts);
  const std::string lines = "type: int16\nendian: little\n";
  add(8, nrrd(lines + "dimension: 3\nsizes: 4 3 2\nencoding: raw\nspace: RAS\nspace directions: "
                      "(1,0,0) (0,2,0) (0,0,3)\nspace origin: (1,2,3)\n",
              shorts));
  add(8, nrrd(lines + "dimension: 4\nsizes: 4 3 1 2\nencoding: gzip\nspacings: 1 2 3 4\n",
              deflated(shorts, /*gzip=*/true)));
  add(8, nrrd(lines + "dimension: 4\nsizes: 2 3 2 2\nencoding: text\nkinds: vector domain domain "
                      "domain\n",
              text));
  add(9, meta_image_header("MET_SHORT", "LOCAL") + shorts);
  add(10, legacy_vtk("BINARY", "short", shorts));
  add(10, legacy_vtk("ASCII", "short", text));
}

void put_big(std::string& bytes, std::uint64_t number, int count) {
  for (int byte = count - 1; byte >= 0; --byte) bytes += static_cast<char>(number >> (8 * byte));
}

// Returns a zip archive of these files, stored without compression.
std::string zip(const std::vector<std::pair<std::string, std::string>>& files) {
  std::string bytes;
  std::string directory;
  for (const auto& [name, content] : files) {
    const auto crc = static_cast<double>(
        crc32_z(0, reinterpret_cast<const Bytef*>(content.data()), content.size()));
    const auto size = static_cast<double>(content.size());
    const auto length = static_cast<double>(name.size());
    const std::string common = packed<std::uint16_t>({20, 0, 0, 0, 0}) +
                               packed<std::uint32_t>({crc, size, size}) +
                               packed<std::uint16_t>({length, 0});
    directory += "PK\1\2" + packed<std::uint16_t>({20}) + common +
                 packed<std::uint16_t>({0, 0, 0}) +
                 packed<std::uint32_t>({0, static_cast<double>(bytes.size())}) + name;
    bytes += "PK\3\4" + common + name + content;
  }
  const auto count = static_cast<double>(files.size());
  return bytes + directory + "PK\5\6" + packed<std::uint16_t>({0, 0, count, count}) +
         packed<std::uint32_t>(
             {static_cast<double>(directory.size()), static_cast<double>(bytes.size())}) +
         packed<std::uint16_t>({0});
}

// Returns 4 x 3 gray pixels.
std::string png() {
  std::string bytes = "\x89PNG\r\n\x1a\n";
  const auto add = [&](const std::string& content) {
    put_big(bytes, content.size() - 4, 4);
    bytes += content;
    put_big(bytes, crc32_z(0, reinterpret_cast<const Bytef*>(content.data()), content.size()), 4);
  };
  std::string header = "IHDR";
  put_big(header, 4, 4);
  put_big(header, 3, 4);
  add(header + std::string("\x08\0\0\0\0", 5));
  std::string rows;
  for (int y = 0; y < 3; ++y) rows += std::string(1, '\0') + "abcd";
  add("IDAT" + deflated(rows, /*gzip=*/false));
  add("IEND");
  return bytes;
}

// Returns one gray block of 8 x 8 pixels.
std::string jpeg() {
  std::string bytes("\xFF\xD8\xFF\xDB\0\x43\0", 7);
  bytes += std::string(64, '\1');
  bytes += std::string("\xFF\xC0\0\x0B\x08\0\x08\0\x08\1\1\x11\0", 13);
  for (const char table : {'\0', '\x10'}) {  // A single code of one bit.
    bytes += std::string("\xFF\xC4\0\x14", 4) + table + '\1' + std::string(15, '\0') + '\0';
  }
  return bytes + std::string("\xFF\xDA\0\x08\1\1\0\0\x3F\0\x3F\xFF\xD9", 13);
}

// In the format of fuzz_more_volumes.cpp.
void write_more_volumes(const std::filesystem::path& folder) {
  const std::vector<double> numbers = values();
  const std::string shorts = packed<std::int16_t>(numbers);
  int number = 0;
  const auto add = [&](int format, const std::string& bytes) {
    write(folder, ++number, std::string(1, static_cast<char>(format)) + bytes);
  };
  for (const std::string order : {"False", "True"}) {
    std::string header = "{'descr': '<i2', 'fortran_order': " + order + ", 'shape': (2, 3, 4), }";
    header += std::string(117 - header.size(), ' ') + "\n";
    add(0, std::string("\x93NUMPY\1\0\x76\0", 10) + header + shorts);
  }
  std::string mgh = packed<std::int32_t>({1, 4, 3, 2, 1, 4, 0}, Endian::kBig) +
                    packed<std::int16_t>({1}, Endian::kBig) +
                    packed<float>({1, 1, 2, -1, 0, 0, 0, 0, -1, 0, 1, 0, 5, 6, 7}, Endian::kBig);
  mgh.resize(284);
  mgh += packed<std::int16_t>(numbers, Endian::kBig);
  add(1, mgh);
  add(2, mgh);
  // NetCDF-3: dimensions z, y, x, no attributes, one variable of shorts.
  std::string netcdf = "CDF\1";
  const auto add_name = [&](const std::string& name) {
    put_big(netcdf, name.size(), 4);
    netcdf += name + std::string((4 - name.size() % 4) % 4, '\0');
  };
  put_big(netcdf, 0, 4);
  put_big(netcdf, 10, 4);
  put_big(netcdf, 3, 4);
  for (const auto& [name, length] : {std::pair{"z", 2}, {"y", 3}, {"x", 4}}) {
    add_name(name);
    put_big(netcdf, static_cast<std::uint64_t>(length), 4);
  }
  put_big(netcdf, 0, 8);
  put_big(netcdf, 11, 4);
  put_big(netcdf, 1, 4);
  add_name("v");
  for (const int word : {3, 0, 1, 2}) put_big(netcdf, static_cast<std::uint64_t>(word), 4);
  put_big(netcdf, 0, 8);
  put_big(netcdf, 3, 4);
  put_big(netcdf, shorts.size(), 4);
  put_big(netcdf, netcdf.size() + 4, 4);
  add(3, netcdf + packed<std::int16_t>(numbers, Endian::kBig));
  std::string text;
  for (const double value : numbers) text += shortest_text(value) + " ";
  const std::string array = R"(<PointData Scalars="a">)"
                            R"(<DataArray type="Int16" Name="a" format="ascii">)";
  add(4, R"(<VTKFile type="PImageData"><PImageData WholeExtent="0 3 0 2 0 1" Spacing="1 1 2">)"
         R"(<PPointData Scalars="a"><PDataArray type="Int16" Name="a"/></PPointData>)"
         R"(<Piece Extent="0 3 0 2 0 1" Source="piece.vti"/></PImageData></VTKFile>)" +
             std::string(1, '\0') +
             R"(<VTKFile type="ImageData" byte_order="LittleEndian"><ImageData )"
             R"(WholeExtent="0 3 0 2 0 1" Spacing="1 1 2"><Piece Extent="0 3 0 2 0 1">)" +
             array + text + "</DataArray></PointData></Piece></ImageData></VTKFile>");
  add(5,
      zip({{"a.zarr/.zarray", R"({"zarr_format":2,"shape":[2,3,4],"chunks":[2,3,4],"dtype":"<i2",)"
                              R"("compressor":null,"fill_value":0,"filters":null,"order":"C"})"},
           {"a.zarr/0.0.0", shorts}}));
  add(6, R"(<emd><map><contour_list><contour primary="true"><level>0.05</level></contour>)"
         R"(<contour><level>1</level></contour></contour_list></map></emd>)");
  add(6, "<map><contourLevel>0.25</contourLevel></map>");
  add(7, R"({"map":{"contour_list":{"contour":[{"level":1},{"primary":true,"level":0.5}]}}})");
  add(8, tiff({packed<std::uint8_t>({numbers.begin(), numbers.begin() + 12}),
               packed<std::uint8_t>({numbers.begin() + 12, numbers.end()})},
              1));
  add(8, tiff({packed<std::uint16_t>({numbers.begin(), numbers.begin() + 12})}, 2));
  add(9, png());
  add(10, jpeg());
  const std::string end(1, '\0');
  std::string imaris;
  for (const char* const attribute : {"4", "3", "2", "-1.5", "0", "0", "2.5", "3", "8e0", "um"}) {
    imaris += attribute + end;
  }
  add(11, imaris);
  add(12,
      R"(<VTKFile type="Collection"><Collection><DataSet timestep="0.5" part="0" file="b.vti"/>)"
      R"(<DataSet timestep="0" group="" file="sub/a.vti"/></Collection></VTKFile>)");
}

// In the format of fuzz_packed_pixels.cpp.
void write_packed_pixels(const std::filesystem::path& folder) {
  int number = 0;
  const auto add = [&](int kind, const std::string& bytes) {
    write(folder, ++number, std::string(1, static_cast<char>(kind)) + bytes);
  };
  add(0, std::string("\x20\0\3abcd\x20\3\xE0\2\1", 12));
  const std::string sizes("\0\x0B\0\0", 4);  // One frame of 12 samples of 8 bits.
  const std::string tag("\xE0\x7F\x10\0OW\0\0", 8);
  add(1, sizes + tag + packed<std::uint32_t>({12}) + std::string(12, 'a'));
  std::string big(sizes + std::string("\x7F\xE0\0\x10OW\0\0", 8));
  put_big(big, 12, 4);
  add(2, big + std::string(12, 'a'));
  const auto fragments = [&](const std::string& frame) {
    const auto item = [](const std::string& content) {
      return packed<std::uint32_t>({double{0xE000FFFE}, static_cast<double>(content.size())}) +
             content;
    };
    return sizes + tag + packed<std::uint32_t>({double{0xFFFFFFFF}}) + item("") + item(frame) +
           packed<std::uint32_t>({double{0xE0DDFFFE}, 0});
  };
  std::string rle = packed<std::uint32_t>({1, 64});
  rle.resize(64);
  add(3, fragments(rle + "\3abcd\xF9z"));
  add(4, fragments(std::string("\xFF\xD8\1\2\3\4\xFF\xD9", 8)));
  std::string part10(128, '\0');
  part10 += "DICM" + std::string("\2\0\0\0UL\4\0", 8) + packed<std::uint32_t>({0});
  const std::string zlib = deflated(std::string(500, 'a'), /*gzip=*/false);
  add(5, part10 + zlib.substr(2, zlib.size() - 6));
}

// In the format of fuzz_mesh_file.cpp.
void write_meshes(const std::filesystem::path& folder) {
  int number = 0;
  const LatticeMesh lattice = surfaces::torus(5, 5, 4, 0.2, 1);
  const PositionedMesh mesh = positioned(lattice, Affine{});
  const std::pair<char, MeshFormat> kinds[] = {{'\0', MeshFormat::kPly}, {'\1', MeshFormat::kStl},
                                               {'\2', MeshFormat::kObj}, {'\3', MeshFormat::kGlb},
                                               {'\4', MeshFormat::kVtp}, {'\5', MeshFormat::k3mf}};
  for (const auto& [kind, format] : kinds) {
    write(folder, ++number, kind + mesh_file(mesh, format));
  }
  write(folder, ++number, '\3' + lattice_glb(lattice, {.exponent = 6}, {1, 2, 3}));
  write(folder, ++number,
        '\3' + lattice_glb(lattice, {.exponent = 6}, {1, 2, 3}, {}, CellCodec::kMeshopt));
  write(folder, ++number,
        std::string(1, '\0') +
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty double y\n"
            "property int z\nelement face 1\nproperty list uchar uint vertex_index\nend_header\n"
            "0 0 0\n1 0 0\n0 1 1\n3 0 1 2\n");
  write(folder, ++number,
        "\1solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
        "endloop\nendfacet\nendsolid a\n");
  write(folder, ++number, "\2v 0 0 0\nv 1 0 0\nv 0 1 0 1\nvn 0 0 1\nf 1//1 2/1/1 -1\n");
  write(folder, ++number,
        "\4<VTKFile type=\"PolyData\" byte_order=\"LittleEndian\"><PolyData><Piece "
        "NumberOfPoints=\"3\" NumberOfPolys=\"1\" NumberOfStrips=\"0\"><Points><DataArray "
        "type=\"Float32\" NumberOfComponents=\"3\" format=\"ascii\">0 0 0 1 0 0 0 1 0"
        "</DataArray></Points><Polys><DataArray type=\"Int32\" Name=\"connectivity\" "
        "format=\"ascii\">0 1 2</DataArray><DataArray type=\"Int32\" Name=\"offsets\" "
        "format=\"ascii\">3</DataArray></Polys></Piece></PolyData></VTKFile>");
}

void write_store_answers(const std::filesystem::path& folder) {
  const std::string end(1, '\0');
  const std::string wanted = packed<std::uint32_t>({10, 20});
  write(folder, 1, end + wanted + "bytes 10-29/1234");
  write(folder, 2, end + wanted + "bytes 10-29/*");
  write(folder, 3, end + wanted + "bytes 1214-1233/1234");
  write(folder, 4,
        "\1<ListBucketResult><IsTruncated>true</IsTruncated><NextContinuationToken>a&amp;b"
        "</NextContinuationToken><Contents><Key>x/&lt;1&gt;.mtd</Key></Contents><Contents><Key>y"
        "</Key></Contents></ListBucketResult>");
  write(folder, 5, "\2some bytes and their sum");
}

void write_client_files(const std::filesystem::path& folder) {
  int number = 0;
  for (const int normal_bits : {0, 8}) {
    const LatticeMesh mesh = surfaces::torus(5, 6, 5, 0.2, 3);
    const std::vector<UnitVector> up(normal_bits == 0 ? 0 : mesh.vertices.size(), {0, 0, 1});
    const EncodedTile tile =
        encode_tile(mesh, {4, 0, 0, 0}, 5, {.directions = up, .bits = normal_bits});
    const TemporaryFolder files;
    TileDiskCache(files.path()).keep(tile.summary, mesh.resolution, normal_bits, *tile.payload);
    std::string digest(16, '\0');
    std::memcpy(digest.data(), &tile.summary.digest, 16);
    write(folder, ++number,
          std::string(1, '\0') + digest +
              bytes_of_file(files.path() / (tile.summary.digest.hex() + ".tile")));
  }
  const std::string place =
      "space: LAS\nspace directions: (0,2,0) (3,0,0) (0,0,4)\nspace origin: (5,6,7)\n";
  const std::string head = "\1NRRD0004\ntype: float\nendian: little\ndimension: 3\nsizes: 2 2 1\n";
  const std::string samples = packed<float>({1, 2, 3, 4});
  write(folder, ++number, head + place + "encoding: raw\n\n" + samples);
  write(folder, ++number,
        head + "spacings: 1 2 nan\naxis mins: 0 1 2\nencoding: gzip\n\n" +
            deflated(samples, /*gzip=*/true));
  write(folder, ++number, head + place + "encoding: ascii\nline skip: 1\n\nx\n1 2 nan +4e-1\n");
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const std::filesystem::path root = argv[1];
  write_volume_metadata(root / "fuzz_volume_metadata");
  write_volume_files(root / "fuzz_volume_file");
  write_more_volumes(root / "fuzz_more_volumes");
  write_packed_pixels(root / "fuzz_packed_pixels");
  write_meshes(root / "fuzz_mesh_file");
  write_store_answers(root / "fuzz_store_answers");
  write_client_files(root / "fuzz_client_file");
  std::mt19937_64 random(1);
  int number = 0;
  for (int i = 0; i < 4; ++i) {
    for (std::size_t kind = 0; kind < std::variant_size_v<ClientMessage>; ++kind) {
      const std::string bytes = serialize(samples::client_message(kind, random));
      write(root / "fuzz_client_message", ++number, bytes);
      write(root / "fuzz_frame", number, "\7" + framed(bytes) + framed(bytes));
    }
    for (std::size_t kind = 0; kind < std::variant_size_v<ServerMessage>; ++kind) {
      write(root / "fuzz_server_message", ++number,
            serialize(samples::server_message(kind, random)));
    }
  }
  for (int speed = 0; speed < 10; ++speed) {
    const auto seed = static_cast<unsigned>(speed);
    write(root / "fuzz_tile", ++number,
          promised_tile(surfaces::torus(5, 6 + speed, 5, 0.2, seed), speed));
    write(root / "fuzz_tile", ++number,
          promised_tile(surfaces::torus(5, 34, 15, 0.2, seed), speed));
    write(root / "fuzz_tile", ++number,
          promised_tile(surfaces::torus(5, 6 + speed, 5, 0.2, seed), speed, 8 + speed % 3));
  }
  write(root / "fuzz_tile", ++number, promised_tile(surfaces::touching_octahedra(5), 5));
  std::ifstream golden(MULTITETRA_TEST_DATA "/small.mtd", std::ios::binary);
  const std::string dataset{std::istreambuf_iterator<char>(golden), {}};
  for (const std::string name : {"example", "exact", "lattice_exact", "quantized"}) {
    const std::string shell = bytes_of_file(MULTITETRA_TEST_DATA "/shell_" + name + ".bin");
    write(root / "fuzz_shell", ++number, shell);
    write(root / "fuzz_shell_round_trip", ++number, shell);
    // In the largest cube at the origin, consistent with the promise.
    write(root / "fuzz_shell_tile", ++number, std::string("\x0f\0\0\0\0\0\0\0", 8) + shell);
  }
  write_whole_datasets(root / "fuzz_whole_dataset");
  write_sandbox_answers(root / "fuzz_sandbox_answer");
  write_dataset_pages(root / "fuzz_dataset_pages", random);
  write(root / "fuzz_dataset_file", ++number, input_of_bytes(dataset));
  write(root / "fuzz_dataset_file", ++number, input_of_sections(dataset));
  for (const char* request :
       {"GET /v1/datasets/a%20b/isosurface?isovalue=-3e2&error=0.5&unit=world&bound=paper&"
        "topology_rule=exact&topology_tolerance=1&lattice=4&region=box:0,0,0,1,1,1=0.5&"
        "region_coordinates=index&view=eye=1,2,3,fov=40,height=1080,pixels=1&combine=minimum&"
        "max_triangles=10&max_bytes=20&normals=8&coordinates=index&format=glb HTTP/1.1\r\n"
        "Host: a\r\nAccept: model/*;q=0.5, */*\r\nIf-None-Match: W/\"1\", \"2\"\r\n\r\n",
        "GET /v1/datasets/a/slice?normal=0,1,1&center=1,2,3&up=1,0,0&extent=4,5&width=6&"
        "coordinates=index&detail=full&window=7&level=8&colors=viridis&format=raw HTTP/1.1\r\n"
        "Host: a\r\n\r\n",
        "GET /v1/datasets/a/probe?at=1,2,3&at=4,5,6&coordinates=index HTTP/1.1\r\nHost: a\r\n\r\n",
        "HEAD /v1/tiles/00112233445566778899aabbccddeeff HTTP/1.1\r\nHost: a\r\n"
        "Range: bytes=1-2\r\nIf-Range: \"1\"\r\nOrigin: https://a.example\r\n\r\n"
        "GET / HTTP/1.0\r\n\r\n"}) {
    write(root / "fuzz_http_request", ++number, request);
  }
  write(root / "fuzz_label_names", ++number,
        "# labels\n0 0 0 0 0 0 0 \"Clear Label\"\n3 221 130 101 1 1 1 \"liver\"\r\n\n");
  write(root / "fuzz_label_names", ++number, "3 liver 221 130 101 255\n-4 \"left lung\" 1 2 3\n");
  write(root / "fuzz_label_names", ++number,
        "Segment0_Name:=liver\nSegment0_Color:=0.5 0 1\nSegment0_LabelValue:=1\nSegment0_Layer:=0\n"
        "Segment12_LabelValue:=1\r\nSegment12_Layer:=1\n");
  std::string triangles(1 + 3 * 60, '\0');
  for (char& byte : triangles) byte = static_cast<char>(random());
  write(root / "fuzz_tile_round_trip", ++number, triangles);
  return 0;
}
