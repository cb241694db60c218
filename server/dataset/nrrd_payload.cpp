#include "server/dataset/nrrd_payload.hpp"

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/text.hpp"
#include "server/dataset/numbered_files.hpp"
#include "server/dataset/payload_size.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

// ---- text

constexpr std::size_t kMaxHeaderBytes = std::size_t{1} << 22;
constexpr std::size_t kMaxSkippedLinesBytes = std::size_t{1} << 16;

// The first bytes of a file, at most `most`.
std::string beginning_of(const fs::path& file, std::size_t most = kMaxHeaderBytes) {
  std::string text(std::min<std::uint64_t>(bytes_after(file, 0), most), '\0');
  std::ifstream in(file, std::ios::binary);
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(in.gcount()));
  return text;
}

// Removes the first line and its end (LF, CR LF or CR) from `text` and returns it without the end;
// nullopt when there is none.
std::optional<std::string_view> take_line(std::string_view& text) {
  if (text.empty()) return std::nullopt;
  const std::size_t length = std::min(text.find_first_of("\r\n"), text.size());
  const std::string_view line = text.substr(0, length);
  text.remove_prefix(length);
  text.remove_prefix(text.starts_with("\r\n") ? 2 : std::min<std::size_t>(1, text.size()));
  return line;
}

// ---- fields

struct NrrdField {
  std::string name;  // In lower case.
  std::string value;
};

// The line "name: value"; nullopt for comments, keys with values, and what is no field.
std::optional<NrrdField> field_of(std::string_view line) {
  const std::size_t colon = line.find(": ");
  if (line.starts_with('#') || colon == std::string_view::npos) return std::nullopt;
  return NrrdField{lower_case(line.substr(0, colon)), std::string(trimmed(line.substr(colon + 2)))};
}

// The fields that say where the samples are.
struct Fields {
  std::string encoding;
  std::string endian;
  std::vector<std::int64_t> sizes;
  std::int64_t line_skip = 0;
  std::int64_t byte_skip = 0;
  std::string data_file;          // Empty: the samples follow the header.
  std::vector<std::string> list;  // The lines after "data file: LIST".
  std::size_t header_bytes = 0;   // With the empty line at its end.
};

bool names_data_files(const NrrdField& field) {
  return field.name == "data file" || field.name == "datafile";
}

// Puts the integer that `text` is into `value`; false when it is none.
bool set_integer(std::int64_t& value, const std::string& text) {
  const std::optional<std::int64_t> number = integer(text);
  value = number.value_or(0);
  return number.has_value();
}

// False when the field is one of ours and not understood.
bool set_field(Fields& fields, const NrrdField& field) {
  const auto& [name, value] = field;
  if (name == "encoding") fields.encoding = lower_case(value);
  if (name == "endian") fields.endian = lower_case(value);
  if (names_data_files(field)) fields.data_file = value;
  if (name == "line skip" || name == "lineskip") return set_integer(fields.line_skip, value);
  if (name == "byte skip" || name == "byteskip") return set_integer(fields.byte_skip, value);
  if (name == "sizes") {
    for (const std::string& word : words_of(value)) {
      if (!set_integer(fields.sizes.emplace_back(), word)) return false;
    }
  }
  return true;
}

std::optional<Fields> fields_of(std::string_view text) {
  Fields fields;
  std::string_view rest = text;
  std::optional<std::string_view> line = take_line(rest);
  if (!line || !line->starts_with("NRRD")) return std::nullopt;
  while ((line = take_line(rest)) && !line->empty()) {
    if (fields.data_file.starts_with("LIST")) {
      fields.list.emplace_back(*line);
    } else if (const auto field = field_of(*line); field && !set_field(fields, *field)) {
      return std::nullopt;
    }
  }
  fields.header_bytes = text.size() - rest.size();
  // Only a detached header may end with the file, instead of an empty line.
  if (!line && fields.data_file.empty()) return std::nullopt;
  return fields;
}

// ---- names of data files

// The data files, in order, as they are named; empty when they are not understood.
std::vector<std::string> data_files(const Fields& fields) {
  const std::string& value = fields.data_file;
  if (value.starts_with("LIST")) {
    return words_of(value)[0] == "LIST" ? fields.list : std::vector<std::string>();
  }
  if (!is_numbered(value)) return value == "-" ? std::vector<std::string>() : std::vector{value};
  const std::optional<NumberedFiles> files = numbered_files(value);
  std::vector<std::string> names;
  if (!files || files->number(0) < 0 || files->number(files->count - 1) < 0) return names;
  for (std::int64_t i = 0; i < files->count; ++i) names.push_back(files->name(i));
  return names;
}

// ---- the samples

// Where the samples begin in a file, after its header and what the fields skip; nullopt when the
// lines to skip are too many or too long.
std::optional<std::uint64_t> offset_in(const fs::path& file, std::size_t header_bytes,
                                       const Fields& fields, std::uint64_t part_bytes) {
  std::uint64_t offset = header_bytes;
  if (fields.line_skip > 0) {
    const std::string text = beginning_of(file, header_bytes + kMaxSkippedLinesBytes);
    std::string_view rest = std::string_view(text).substr(std::min(header_bytes, text.size()));
    for (std::int64_t i = 0; i < fields.line_skip; ++i) {
      if (!take_line(rest) || rest.empty()) return std::nullopt;
    }
    offset = text.size() - rest.size();
  }
  if (fields.byte_skip >= 0) return offset + static_cast<std::uint64_t>(fields.byte_skip);
  const std::uint64_t size = bytes_after(file, 0);  // -1: the samples end the file.
  return size < part_bytes ? 0 : size - part_bytes;
}

bool is_packed(const Fields& fields) {
  return fields.encoding == "gzip" || fields.encoding == "gz" || fields.encoding == "bzip2" ||
         fields.encoding == "bz2";
}

bool is_plain(const Fields& fields, const ImageHeader& header) {
  if (fields.encoding != "raw" && !is_packed(fields)) return false;
  // Skipped bytes of what is packed are unpacked ones, which have no end to count from.
  if (fields.line_skip < 0 || fields.byte_skip < (is_packed(fields) ? 0 : -1)) return false;
  const bool has_order = fields.endian == "little" || fields.endian == "big";
  if (bytes_of(header.type) > 1 && !has_order) return false;
  if (fields.sizes.size() < 2 || fields.sizes.size() > 3) return false;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (header.dims[axis] != (axis < fields.sizes.size() ? fields.sizes[axis] : 1)) return false;
  }
  return true;
}

}  // namespace

void check_nrrd_header(const fs::path& file, bool follow) {
  const std::string text = beginning_of(file);
  std::string_view rest = text;
  std::optional<std::string_view> line;
  bool in_list = false;
  while ((line = take_line(rest)) && !line->empty()) {
    if (in_list) (void)named_data_file(file, std::string(*line), follow);
    const std::optional<NrrdField> field = field_of(*line);
    if (in_list || !field || !names_data_files(*field)) continue;
    in_list = field->value.starts_with("LIST");
    if (in_list || field->value == "-") continue;
    if (!is_numbered(field->value)) {
      (void)named_data_file(file, field->value, follow);
      continue;
    }
    const auto files = numbered_files(field->value);
    if (!files) {
      fail_reading(file, "its data files are named by '" + field->value + "'",
                   "A pattern has one number such as %d or %03d and is followed by the first "
                   "number, the last and the step");
    }
    for (std::int64_t i = 0; i < files->count; ++i) {
      (void)named_data_file(file, files->name(i), follow);
    }
  }
  if (!line && text.size() == kMaxHeaderBytes) {
    fail_reading(file, "its header has more than " + std::to_string(kMaxHeaderBytes) + " bytes",
                 "Check that it is a whole file of this format");
  }
}

std::optional<PlainPayload> plain_nrrd_payload(const fs::path& file, const ImageHeader& header) {
  const std::optional<Fields> fields = fields_of(beginning_of(file));
  if (!fields || !is_plain(*fields, header)) return std::nullopt;
  const bool attached = fields->data_file.empty();
  const std::vector<std::string> names =
      attached ? std::vector{file.filename().string()} : data_files(*fields);
  const auto parts = static_cast<std::int64_t>(names.size());
  if (parts == 0 || header.dims[2] % parts != 0) return std::nullopt;
  if (is_packed(*fields) && parts != 1) return std::nullopt;

  PlainPayload payload;
  payload.endian = fields->endian == "big" ? Endian::kBig : Endian::kLittle;
  payload.part_bytes = header.slice_bytes() * static_cast<std::uint64_t>(header.dims[2] / parts);
  Fields skipped = *fields;
  if (is_packed(*fields)) {
    payload.unpacked_offset = static_cast<std::uint64_t>(fields->byte_skip);
    skipped.byte_skip = 0;
  }
  for (const std::string& name : names) {
    const fs::path part = file.parent_path() / name;
    const std::optional<std::uint64_t> offset =
        offset_in(part, attached ? fields->header_bytes : 0, skipped, payload.part_bytes);
    if (!offset) return std::nullopt;
    payload.parts.push_back({part, *offset});
  }
  return payload;
}

}  // namespace multitetra
