#include "server/volume/formats/vtk/detail/vti_header.hpp"

#include <expat.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <memory>
#include <sstream>

#include "server/volume/formats/detail/xml_document.hpp"

namespace multitetra {
namespace {

using Attributes = std::map<std::string, std::string, std::less<>>;

constexpr std::size_t kMaxArrays = 4096;
constexpr int kMaxDepth = 64;
constexpr std::string_view kFieldData = "FieldData";
constexpr std::uint64_t kMaxTagBytes = std::uint64_t{1} << 20;
constexpr std::uint64_t kMaxMarkupBytes = std::uint64_t{1} << 26;  // Excludes text between tags.

// Parses exactly `count` numbers separated by white space.
template <typename Number, std::size_t count>
bool read_numbers(const std::string& text, std::array<Number, count>& into) {
  std::istringstream in(text);
  in.imbue(std::locale::classic());
  for (Number& number : into) {
    if (!(in >> number)) return false;
  }
  std::string rest;
  return !(in >> rest);
}

class VtiParser {
 public:
  explicit VtiParser(VtkDataKind kind)
      : parser_(XML_ParserCreate(nullptr), &XML_ParserFree), kind_(kind) {
    XML_SetUserData(parser_.get(), this);
    XML_SetElementHandler(parser_.get(), &on_start, &on_end);
    XML_SetCharacterDataHandler(parser_.get(), &on_text);
    // Valid files have no entities, and their expansion is unbounded.
    XML_SetEntityDeclHandler(parser_.get(), &on_entity);
  }

  Result<VtiHeader> parse(const NextBytes& next) {
    std::uint64_t before = 0;  // Bytes passed to the parser before this portion.
    while (true) {
      const std::string_view bytes = next();
      const bool last = bytes.empty();
      const auto status = XML_Parse(parser_.get(), bytes.data(), static_cast<int>(bytes.size()),
                                    last ? XML_TRUE : XML_FALSE);
      if (!failure_.empty()) return fail(ErrorCode::kInvalidArgument, failure_);
      if (in_appended_) return find_appended(next, bytes, before);
      if (status != XML_STATUS_OK) {
        return fail(ErrorCode::kDamagedData,
                    std::string("its XML is damaged in line ") +
                        std::to_string(XML_GetCurrentLineNumber(parser_.get())) + " (" +
                        XML_ErrorString(XML_GetErrorCode(parser_.get())) + ")");
      }
      before += bytes.size();
      if (last) return finished();
      // An unfinished tag is parsed again with every portion, in quadratic time.
      const std::int64_t parsed = XML_GetCurrentByteIndex(parser_.get());
      if (before - static_cast<std::uint64_t>(std::max<std::int64_t>(parsed, 0)) > kMaxTagBytes) {
        return fail(ErrorCode::kDamagedData,
                    "a tag of its XML is longer than " + std::to_string(kMaxTagBytes) + " bytes");
      }
    }
  }

 private:
  static void XMLCALL on_start(void* self, const XML_Char* name, const XML_Char** attributes) {
    Attributes map;
    for (const XML_Char** at = attributes; *at != nullptr; at += 2) map[at[0]] = at[1];
    static_cast<VtiParser*>(self)->start(name, map);
  }
  static void XMLCALL on_end(void* self, const XML_Char* name) {
    static_cast<VtiParser*>(self)->end(name);
  }
  static void XMLCALL on_text(void* self, const XML_Char* text, int length) {
    static_cast<VtiParser*>(self)->add_text({text, static_cast<std::size_t>(length)});
  }
  static void XMLCALL on_entity(void* self, const XML_Char*, int, const XML_Char*, int,
                                const XML_Char*, const XML_Char*, const XML_Char*,
                                const XML_Char*) {
    static_cast<VtiParser*>(self)->print_error("it declares XML entities, which are not allowed");
  }

  void print_error(const std::string& text) {
    if (failure_.empty()) failure_ = text;
    XML_StopParser(parser_.get(), XML_FALSE);
  }

  [[nodiscard]] std::uint64_t position() const {
    return static_cast<std::uint64_t>(XML_GetCurrentByteIndex(parser_.get()));
  }

  void add_text(std::string_view text) {
    if (open_array_ != depth_ || has_samples_) return;
    has_samples_ = text.find_first_not_of(" \t\r\n") != std::string_view::npos;
  }

  void start(std::string_view name, const Attributes& attributes) {
    if (open_array_ != 0 && has_samples_ && header_.arrays.back().end == 0) {
      header_.arrays.back().end = position();
    }
    const auto get = [&](std::string_view key) {
      const auto found = attributes.find(key);
      return found == attributes.end() ? std::string() : found->second;
    };
    const auto markup = static_cast<std::uint64_t>(XML_GetCurrentByteCount(parser_.get()));
    if (++depth_ > kMaxDepth || (markup_bytes_ += markup) > kMaxMarkupBytes) {
      return print_error("its XML has too many tags");
    }
    if (depth_ == 1 && name != "VTKFile") return print_error("it is not a VTK file");
    if (name == "VTKFile") start_file(get("type"), get("byte_order"), get("header_type"));
    if (name == "VTKFile") header_.compressor = get("compressor");
    if (name == "ImageData")
      start_image(get("WholeExtent"), get("Origin"), get("Spacing"), get("Direction"));
    if (name == "Piece" && kind_ == VtkDataKind::kImageData) start_piece(get("Extent"));
    if (name == "Piece" && kind_ == VtkDataKind::kPolyData) {
      start_poly_piece(get("NumberOfPoints"), get("NumberOfPolys"), get("NumberOfStrips"));
    }
    if (is_section(name)) {
      in_arrays_ = true;
      section_ = name;
      of_cells_ = name == "CellData";
      if (name == "PointData") header_.scalars = get("Scalars");
      if (name == "CellData") header_.cell_scalars = get("Scalars");
    }
    const bool is_time = get("Name") == "TimeValue" && get("NumberOfTuples") == "1";
    if (name == "DataArray" && in_arrays_ && (section_ != kFieldData || is_time)) {
      start_array(attributes);
    }
    if (name == "AppendedData") {
      const std::string encoding = get("encoding");
      if (encoding != "raw" && encoding != "base64") {
        return print_error("its appended data has an unknown encoding: '" + encoding.substr(0, 40) +
                           "'");
      }
      header_.appended_raw = encoding == "raw";
      in_appended_ = true;
      appended_tag_ = position();
      XML_StopParser(parser_.get(), XML_FALSE);  // The rest need not be XML.
    }
  }

  void start_file(const std::string& type, const std::string& order, const std::string& lengths) {
    const std::string wanted = kind_ == VtkDataKind::kImageData ? "ImageData" : "PolyData";
    if (type != wanted) {
      return print_error("it has " + (type.empty() ? "nothing" : type.substr(0, 40)) +
                         " instead of " + wanted);
    }
    header_.endian = order == "BigEndian" ? Endian::kBig : Endian::kLittle;
    header_.length_bytes = lengths == "UInt64" ? 8 : 4;
    if (!order.empty() && order != "BigEndian" && order != "LittleEndian") {
      print_error("its byte_order is invalid: '" + order.substr(0, 40) + "'");
    }
    if (!lengths.empty() && lengths != "UInt64" && lengths != "UInt32") {
      print_error("its header_type is invalid: '" + lengths.substr(0, 40) + "'");
    }
  }

  void start_image(const std::string& extent, const std::string& origin, const std::string& spacing,
                   const std::string& direction) {
    if (!read_numbers(extent, header_.extent))
      return print_error("its WholeExtent is not six integers");
    for (std::size_t axis = 0; axis < 3; ++axis) {
      constexpr std::int64_t kFar = std::int64_t{1} << 40;
      const std::int64_t low = header_.extent[2 * axis];
      const std::int64_t high = header_.extent[2 * axis + 1];
      if (low > high || low < -kFar || high > kFar) {
        return print_error("its WholeExtent '" + extent.substr(0, 100) + "' is empty or too large");
      }
    }
    if (!origin.empty() && !read_numbers(origin, header_.origin.emplace())) {
      print_error("its Origin is not three numbers");
    }
    if (!spacing.empty() && !read_numbers(spacing, header_.spacing.emplace())) {
      print_error("its Spacing is not three numbers");
    }
    std::array<double, 9> rows{};
    if (direction.empty()) return;
    if (!read_numbers(direction, rows)) return print_error("its Direction is not nine numbers");
    for (std::size_t row = 0; row < 3; ++row) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        header_.directions[axis][row] = rows[3 * row + axis];
      }
    }
  }

  void start_piece(const std::string& extent) {
    std::array<std::int64_t, 6> piece{};
    if (++pieces_ > 1) return print_error("it has several pieces; save it as one");
    bool is_inside = read_numbers(extent, piece);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::int64_t low = piece[2 * axis];
      const std::int64_t high = piece[2 * axis + 1];
      is_inside = is_inside && low <= high && low >= header_.extent[2 * axis] &&
                  high <= header_.extent[2 * axis + 1];
    }
    if (!is_inside) {
      print_error("its piece has the extent '" + extent.substr(0, 100) +
                  "', which is outside the whole extent");
    }
    header_.piece = piece;
  }

  void start_poly_piece(const std::string& points, const std::string& polys,
                        const std::string& strips) {
    if (++pieces_ > 1) return print_error("it has several pieces; save it as one");
    const auto count = [this](const std::string& text) -> std::uint64_t {
      std::array<std::int64_t, 1> number{};
      constexpr std::int64_t kMax = 0xFFFFFFFF;
      if (text.empty()) return 0;
      if (!read_numbers(text, number) || number[0] < 0 || number[0] > kMax) {
        print_error("its piece has '" + text.substr(0, 40) + "' points or cells");
      }
      return static_cast<std::uint64_t>(number[0]);
    };
    header_.points = count(points);
    header_.polys = count(polys);
    header_.strips = count(strips);
  }

  [[nodiscard]] bool is_section(std::string_view name) const {
    if (kind_ == VtkDataKind::kImageData) {
      return name == "PointData" || name == "CellData" || name == kFieldData;
    }
    return name == "Points" || name == "Polys" || name == "Strips";
  }

  void start_array(const Attributes& attributes) {
    const auto get = [&](std::string_view key, std::string otherwise) {
      const auto found = attributes.find(key);
      return found == attributes.end() ? otherwise : found->second;
    };
    if (header_.arrays.size() >= kMaxArrays) return print_error("it has too many arrays");
    VtiArray array{.name = get("Name", ""), .of_cells = of_cells_, .section = section_};
    const std::string type = get("type", "");
    const auto known = stored_type_from_word(type);
    if (!known) return;  // Text and bits are not supported.
    array.type = *known;
    const std::string components = get("NumberOfComponents", "1");
    std::array<std::int64_t, 1> count{};
    if (!read_numbers(components, count) || count[0] < 1 || count[0] > kMaxComponents) {
      return print_error("its array '" + array.name.substr(0, 100) + "' has " +
                         components.substr(0, 40) + " components");
    }
    array.components = count[0];
    const std::string format = get("format", "ascii");
    if (format == "binary") array.format = VtiArray::Format::kBase64;
    if (format == "appended") {
      array.format = VtiArray::Format::kAppended;
      std::array<std::uint64_t, 1> offset{};
      const std::string text = get("offset", "");
      if (text.starts_with('-') || !read_numbers(text, offset)) {
        return print_error("its array '" + array.name.substr(0, 100) + "' has no offset");
      }
      array.begin = offset[0];
    } else if (format != "binary" && format != "ascii") {
      return print_error("its array '" + array.name.substr(0, 100) + "' has the unknown format '" +
                         format.substr(0, 40) + "'");
    } else {
      array.begin = position() + static_cast<std::uint64_t>(XML_GetCurrentByteCount(parser_.get()));
      open_array_ = depth_;
      has_samples_ = false;
    }
    header_.arrays.push_back(std::move(array));
  }

  void end(std::string_view name) {
    if (open_array_ == depth_) {
      if (header_.arrays.back().end == 0) header_.arrays.back().end = position();
      open_array_ = 0;
    } else if (open_array_ != 0 && !has_samples_) {
      // Skips <InformationKey> and the like before the text of the samples; VTK writes them behind.
      header_.arrays.back().begin =
          position() + static_cast<std::uint64_t>(XML_GetCurrentByteCount(parser_.get()));
    }
    if (is_section(name)) in_arrays_ = false;
    --depth_;
  }

  // Finds the bytes after the underscore of <AppendedData ...>_; `bytes` begin at `before`.
  Result<VtiHeader> find_appended(const NextBytes& next, std::string_view bytes,
                                  std::uint64_t before) {
    bool in_tag = true;
    std::uint64_t at = appended_tag_;
    while (!bytes.empty() && at < appended_tag_ + kMaxTagBytes) {
      for (; at - before < bytes.size(); ++at) {
        const char byte = bytes[at - before];
        if (!in_tag && byte == '_') {
          header_.appended = at + 1;
          return finished();
        }
        if (byte == '>') in_tag = false;
      }
      before += bytes.size();
      bytes = next();
    }
    return fail(ErrorCode::kDamagedData, "its appended data does not begin with an underscore");
  }

  Result<VtiHeader> finished() {
    if (pieces_ == 0) return fail(ErrorCode::kInvalidArgument, "it has no piece");
    std::erase_if(header_.arrays, [&](const VtiArray& array) {
      if (array.section != kFieldData) return false;
      header_.time = array;
      return true;
    });
    return header_;
  }

  std::unique_ptr<XML_ParserStruct, decltype(&XML_ParserFree)> parser_;
  VtkDataKind kind_;
  VtiHeader header_;
  std::string section_;
  std::string failure_;
  int depth_ = 0;
  int pieces_ = 0;
  int open_array_ = 0;        // Depth of the open array; 0 if there is none.
  bool has_samples_ = false;  // Text of samples has begun in the open array.
  std::uint64_t markup_bytes_ = 0;
  std::uint64_t appended_tag_ = 0;
  bool in_arrays_ = false;
  bool of_cells_ = false;
  bool in_appended_ = false;
};

}  // namespace

Result<PvtiHeader> parse_pvti(std::string_view text) {
  const Result<XmlElement> xml = parse_xml(text);
  if (!xml) return tl::unexpected(xml.error());
  PvtiHeader header;
  const XmlElement* const image = xml->child("PImageData");
  bool is_whole = xml->attribute("type") == "PImageData" && image != nullptr &&
                  read_numbers(image->attribute("WholeExtent"), header.extent);
  constexpr std::int64_t kFar = std::int64_t{1} << 40;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int64_t low = header.extent[2 * axis];
    const std::int64_t high = header.extent[2 * axis + 1];
    is_whole = is_whole && low <= high && low >= -kFar && high <= kFar;
  }
  if (!is_whole) {
    return fail(ErrorCode::kInvalidArgument,
                "it is not a PImageData with an extent of six integers");
  }
  for (const XmlElement* const piece : image->all("Piece")) {
    header.pieces.push_back(piece->attribute("Source"));
  }
  return header;
}

Result<VtiHeader> parse_vti(const NextBytes& next, VtkDataKind kind) {
  return VtiParser(kind).parse(next);
}

}  // namespace multitetra
