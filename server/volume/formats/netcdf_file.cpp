#include "server/volume/formats/netcdf_file.hpp"

#include <netcdf.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/volume/formats/arrays/array_volume.hpp"
#include "server/volume/formats/detail/input_file.hpp"
#include "server/volume/formats/detail/netcdf_size.hpp"
#include "server/volume/formats/hdf5/detail/hdf5_container.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxAttribute = 4096;

// A variable, or a group with the id NC_GLOBAL.
struct NetcdfObject {
  int group = -1;
  int variable = NC_GLOBAL;
};

class NetcdfContainer : public ArrayContainer {
 public:
  explicit NetcdfContainer(fs::path path) : path_(std::move(path)) {
    setenv("HDF5_USE_FILE_LOCKING", "FALSE", 0);  // Other programs may have the file open.
    setenv("NCRCENV_IGNORE", "1", 1);             // No settings of the user's folders.
    const int state = nc_open(fs::absolute(path_).c_str(), NC_NOWRITE, &id_);
    if (state == NC_NOERR) return;
    fail_damaged(path_, std::string("the netCDF library cannot open it: ") + nc_strerror(state));
  }
  ~NetcdfContainer() override { nc_close(id_); }
  NetcdfContainer(const NetcdfContainer&) = delete;
  NetcdfContainer& operator=(const NetcdfContainer&) = delete;

  [[nodiscard]] int id() const { return id_; }
  [[nodiscard]] fs::path file() const override { return path_; }

  [[nodiscard]] std::vector<std::string> arrays() const override {
    std::vector<std::string> found;
    visit_variables(id_, "", [&](const std::string& path) {
      std::size_t sides = 0;
      for (const std::int64_t side : shape(path)) sides += side > 1;
      if (sides >= 2) found.push_back(path);
    });
    return found;
  }

  [[nodiscard]] std::vector<std::int64_t> shape(const std::string& array) const override {
    const NetcdfObject found = object(array);
    if (found.variable == NC_GLOBAL || !type(array)) return {};
    std::vector<std::int64_t> sides;
    for (const int dimension : dimensions(found)) {
      std::size_t length = 0;
      nc_inq_dimlen(found.group, dimension, &length);
      sides.push_back(static_cast<std::int64_t>(std::min(length, std::size_t{1} << 62)));
    }
    return sides;
  }

  [[nodiscard]] std::optional<StoredType> type(const std::string& array) const override {
    const NetcdfObject found = object(array);
    nc_type type = NC_NAT;
    if (found.variable != NC_GLOBAL) nc_inq_vartype(found.group, found.variable, &type);
    return netcdf_type(type);
  }

  [[nodiscard]] std::vector<double> values(const std::string& array) const override {
    const NetcdfObject found = object(array);
    if (found.variable == NC_GLOBAL || !type(array)) return {};
    std::size_t count = 1;
    for (const std::int64_t side : shape(array)) {
      if (__builtin_mul_overflow(count, static_cast<std::size_t>(side), &count) ||
          count > kMaxValues)
        return {};
    }
    std::vector<double> values(count);
    const int state = nc_get_var_double(found.group, found.variable, values.data());
    return state == NC_NOERR || state == NC_ERANGE ? values : std::vector<double>();
  }

  [[nodiscard]] std::vector<double> numbers(const std::string& path,
                                            const char* attribute) const override {
    const NetcdfObject found = object(path);
    nc_type type = NC_NAT;
    std::size_t length = 0;
    if (nc_inq_att(found.group, found.variable, attribute, &type, &length) != NC_NOERR ||
        !netcdf_type(type) || length > kMaxAttribute)
      return {};
    std::vector<double> numbers(length);
    nc_get_att_double(found.group, found.variable, attribute, numbers.data());
    return numbers;
  }

  [[nodiscard]] bool has_floats(const std::string& path, const char* attribute) const override {
    const NetcdfObject found = object(path);
    nc_type type = NC_NAT;
    return nc_inq_atttype(found.group, found.variable, attribute, &type) == NC_NOERR &&
           (type == NC_FLOAT || type == NC_DOUBLE);
  }

  [[nodiscard]] std::vector<std::string> texts(const std::string& path,
                                               const char* attribute) const override {
    const NetcdfObject found = object(path);
    nc_type type = NC_NAT;
    std::size_t length = 0;
    if (nc_inq_att(found.group, found.variable, attribute, &type, &length) != NC_NOERR ||
        length == 0 || length > kMaxAttribute)
      return {};
    if (type == NC_CHAR) {
      std::string text(length, '\0');
      nc_get_att_text(found.group, found.variable, attribute, text.data());
      return {text.substr(0, text.find('\0'))};
    }
    if (type != NC_STRING) return {};
    std::vector<char*> pointers(length, nullptr);
    std::vector<std::string> texts;
    if (nc_get_att_string(found.group, found.variable, attribute, pointers.data()) != NC_NOERR)
      return {};
    for (const char* text : pointers) texts.emplace_back(text == nullptr ? "" : text);
    nc_free_string(length, pointers.data());
    return texts;
  }

  [[nodiscard]] std::vector<std::string> dimension_names(const std::string& array) const override {
    const NetcdfObject found = object(array);
    std::vector<std::string> names;
    for (const int dimension : dimensions(found)) {
      std::array<char, NC_MAX_NAME + 1> name{};
      nc_inq_dimname(found.group, dimension, name.data());
      names.emplace_back(name.data());
    }
    return names;
  }

  // The variable of one dimension that has its name, in the group of the array or one around it.
  [[nodiscard]] std::string coordinates(const std::string& array,
                                        std::size_t dimension) const override {
    const std::vector<int> own = dimensions(object(array));
    const std::string name = dimension_names(array).at(dimension);
    std::string group = array;
    while (!group.empty()) {
      group = group_of(group);
      const std::string path = group + "/" + name;
      if (dimensions(object(path)) == std::vector{own[dimension]}) return path;
    }
    return {};
  }

  // Finds "/group/name"; a group has no variable. The group is invalid if there is no such object.
  [[nodiscard]] NetcdfObject object(std::string_view path) const {
    NetcdfObject found{.group = id_};
    while (!path.empty()) {
      path.remove_prefix(path.starts_with('/') ? 1 : 0);
      const std::string part(path.substr(0, path.find('/')));
      path.remove_prefix(part.size());
      if (part.empty()) continue;
      int group = -1;
      const bool is_last = path.empty();
      if (is_last && nc_inq_varid(found.group, part.c_str(), &found.variable) == NC_NOERR)
        return found;
      if (nc_inq_grp_ncid(found.group, part.c_str(), &group) != NC_NOERR) return {};
      found = {.group = group};
    }
    return found;
  }

 private:
  [[nodiscard]] static std::vector<int> dimensions(const NetcdfObject& variable) {
    int count = 0;
    if (variable.variable == NC_GLOBAL ||
        nc_inq_varndims(variable.group, variable.variable, &count) != NC_NOERR)
      return {};
    std::vector<int> ids(static_cast<std::size_t>(count));
    nc_inq_vardimid(variable.group, variable.variable, ids.data());
    return ids;
  }

  void visit_variables(int group, const std::string& prefix,
                       const std::function<void(const std::string&)>& visit) const {
    int count = 0;
    nc_inq_nvars(group, &count);
    std::array<char, NC_MAX_NAME + 1> name{};
    for (int variable = 0; variable < count; ++variable) {
      nc_inq_varname(group, variable, name.data());
      visit(prefix + "/" + name.data());
    }
    nc_inq_grps(group, &count, nullptr);
    std::vector<int> groups(static_cast<std::size_t>(count));
    nc_inq_grps(group, &count, groups.data());
    for (const int inner : groups) {
      nc_inq_grpname(inner, name.data());
      visit_variables(inner, prefix + "/" + name.data(), visit);
    }
  }

  fs::path path_;
  int id_ = -1;
};

void check_size(const NetcdfContainer& container, int format) {
  const std::uint64_t needed = least_classic_bytes(container.id(), format);
  const std::uint64_t found = InputFile(container.file()).size();
  // The last padding may be missing.
  if (found + 3 >= needed) return;
  fail_incomplete(container.file(), "it ends too early: its header declares at least " +
                                        std::to_string(needed) + " bytes, but it has " +
                                        std::to_string(found) + " bytes");
}

class NetcdfReader : public ArrayReader {
 public:
  NetcdfReader(std::unique_ptr<NetcdfContainer> file, const std::string& array)
      : file_(std::move(file)), variable_(file_->object(array)) {}

  void read(const std::vector<std::int64_t>& start, const std::vector<std::int64_t>& extent,
            std::byte* into) override {
    const std::vector<std::size_t> first(start.begin(), start.end());
    const std::vector<std::size_t> count(extent.begin(), extent.end());
    const int state =
        nc_get_vara(variable_.group, variable_.variable, first.data(), count.data(), into);
    if (state == NC_NOERR) return;
    fail_damaged(file_->file(),
                 std::string("a part of its samples cannot be read: ") + nc_strerror(state));
  }

 private:
  std::unique_ptr<NetcdfContainer> file_;
  NetcdfObject variable_;
};

// Samples that were never written have _FillValue, or else the value that fills variables of this
// type, whatever else is missing. Bytes have none, and small integers may have that value for
// another reason, which is told.
void set_default_fill(const NetcdfContainer& file, const std::string& array, StoredVolume& volume,
                      VolumeInArray& place) {
  const NetcdfObject variable = file.object(array);
  std::array<std::byte, 8> fill{};
  int is_unfilled = 0;
  const StoredType type = *file.type(array);
  if (!file.numbers(array, "_FillValue").empty() || bytes_of(type) == 1) return;
  if (nc_inq_var_fill(variable.group, variable.variable, &is_unfilled, fill.data()) != NC_NOERR ||
      is_unfilled != 0)
    return;
  const double value = number_from(type, fill.data());
  if (bytes_of(type) == 2) {
    place.unwritten = value;
    place.unwritten_notice = "'" + file.file().string() + "': some samples are " +
                             std::to_string(static_cast<int>(value)) +
                             ", as samples that were never written; they are kept.";
  } else {
    volume.header.missing.push_back(value);
  }
}

// Returns our reader of HDF5, which checks chunks more than libhdf5 does. Returns none for a
// variable that has not all records of its unlimited dimensions: the library fills them.
std::unique_ptr<ArrayReader> checked_reader(const fs::path& path, const std::string& array,
                                            const std::vector<std::int64_t>& shape,
                                            const VolumeChoice& choice,
                                            std::vector<std::string>& notices) {
  Hdf5Id file = open_hdf5_file(path);
  if (Hdf5Container(path, file.get(), choice.allow_external_files).shape(array) != shape) return {};
  const std::string unwritten =
      unwritten_notice(path, file.get(), array, choice.allow_external_files);
  if (!unwritten.empty()) notices.push_back(unwritten);
  return hdf5_reader(path, std::move(file), array, choice.allow_external_files);
}

}  // namespace

bool is_classic_netcdf(std::string_view beginning) {
  return beginning.size() >= 4 && beginning.starts_with("CDF") &&
         (beginning[3] == 1 || beginning[3] == 2 || beginning[3] == 5);
}

StoredVolume open_netcdf(const fs::path& path, const VolumeChoice& choice) {
  auto file = std::make_unique<NetcdfContainer>(path);
  int format = 0;
  nc_inq_format(file->id(), &format);
  const bool is_hdf5 = format == NC_FORMAT_NETCDF4 || format == NC_FORMAT_NETCDF4_CLASSIC;
  if (!is_hdf5) check_size(*file, format);
  const std::string array = chosen_array(*file, choice);
  if (file->shape(array).empty()) {
    std::string names;
    for (const std::string& name : file->arrays())
      names += (names.empty() ? "" : ", ") + name.substr(1);
    fail_reading(path, "it has no variable '" + array + "'; there are " + names.substr(0, 600),
                 "Give one, as in '" + path.filename().string() + ":/name'");
  }
  const std::vector<std::int64_t> shape = file->shape(array);
  ArrayMeaning meaning = meaning_of(*file, array);
  const bool is_plain = meaning.name.empty();
  VolumeInArray place;
  StoredVolume volume = described_volume(*file, array, std::move(meaning), choice,
                                         /*has_components=*/true, place);
  if (is_plain) set_default_fill(*file, array, volume, place);
  if (choice.first) list_arrays(*file, array, volume.contents);
  std::unique_ptr<ArrayReader> reader;
  if (is_hdf5) {
    file.reset();  // libhdf5 opens no file twice with different properties.
    reader = checked_reader(path, array, shape, choice, volume.notices);
    if (!reader) file = std::make_unique<NetcdfContainer>(path);
  }
  if (!reader) reader = std::make_unique<NetcdfReader>(std::move(file), array);
  volume.slices = array_slices(std::move(reader), shape, std::move(place));
  return volume;
}

}  // namespace multitetra
