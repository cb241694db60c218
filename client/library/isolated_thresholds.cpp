#include "client/library/isolated_thresholds.hpp"

#include <system_error>

#include "client/library/nrrd_thresholds.hpp"
#include "common/base/printable_line.hpp"
#include "common/sandbox/packed.hpp"
#include "common/sandbox/sandbox.hpp"

namespace multitetra {

inline auto fields(ThresholdGrid& grid) {
  return std::tie(grid.dims, grid.index_to_world, grid.thresholds);
}

namespace {

namespace fs = std::filesystem;

// An answer is a grid, or the code and text of an error.
const SandboxTask kReadThresholds =
    answering("read thresholds", [](const std::string& request) -> std::string {
      fs::path file;
      double elsewhere = 0;
      std::string length_unit;
      if (!unpack_all(request, file, elsewhere, length_unit)) {
        throw std::logic_error("not a request");
      }
      const auto grid = read_nrrd_thresholds(file, elsewhere, length_unit);
      if (grid) return packed_values(true, *grid);
      return packed_values(false, grid.error().code, grid.error().text);
    });

}  // namespace

Result<ThresholdGrid> read_thresholds_isolated(const fs::path& file, double elsewhere,
                                               const std::string& length_unit) {
  constexpr std::uint64_t kMostMemory = std::uint64_t{12} << 30;  // For the largest images.
  const auto damaged = [&file](const std::string& why) {
    return fail(ErrorCode::kDamagedData, "Cannot read the threshold grid \"" + file.string() +
                                             "\": " + printable(why) + ".");
  };
  std::error_code ignored;
  const fs::path whole = fs::absolute(file, ignored);
  try {
    const std::string answer = run_in_sandbox(
        kReadThresholds, {.readable = {whole, whole.parent_path()}, .memory_bytes = kMostMemory},
        packed_values(whole, elsewhere, length_unit));
    std::string_view left = answer;
    bool is_read = false;
    ThresholdGrid grid;
    if (!unpack(left, is_read)) return damaged("its reader does not answer as a reader does");
    if (is_read && unpack_all(left, grid)) return grid;
    Error error;
    if (!is_read && unpack_all(left, error.code, error.text)) {
      const bool is_limit = error.code == ErrorCode::kLimitExceeded;
      return fail(is_limit ? error.code : ErrorCode::kInvalidArgument, printable(error.text));
    }
    return damaged("its reader does not answer as a reader does");
  } catch (const std::runtime_error& problem) {
    return damaged(problem.what());
  }
}

}  // namespace multitetra
