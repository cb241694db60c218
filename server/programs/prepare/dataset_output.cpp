#include "server/programs/prepare/dataset_output.hpp"

#include <string>
#include <system_error>

#include "common/base/exit_codes.hpp"
#include "server/dataset/section_table.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse_to_replace(const fs::path& output) {
  throw ExitError(kUsage, "--output: " + output.string() +
                              " exists and is not a dataset; --force replaces it.");
}

}  // namespace

DatasetOutput::DatasetOutput(const fs::path& output, bool force) : output_(output), file_(output) {
  if (!force && output.extension() != ".mtd") {
    throw ExitError(kUsage, "--output: the name of a dataset must end in .mtd, and \"" +
                                output.string() + "\" does not; --force uses it anyway.");
  }
  if (!is_address(output.string())) {
    std::error_code none;
    const auto size = fs::file_size(output, none);
    if (!force && !none && size > 0 && !begins_as_dataset(output)) refuse_to_replace(output);
    return;
  }
  if (!output.string().starts_with("s3://")) {
    throw ExitError(kUsage, "--output: datasets are written to files and to s3://, not to " +
                                output.string() + ".");
  }
  const auto existing = find_object(output.string(), kMagicBytes);
  if (existing && !force && !begins_as_dataset(existing->begin)) refuse_to_replace(output);
  using Kind = UploadCondition::Kind;
  condition_ = {.kind = force ? Kind::kAny : (existing ? Kind::kSameVersion : Kind::kAbsent),
                .etag = existing ? existing->etag : ""};
  file_ = temporary_.emplace().path() / "dataset.mtd";
}

void DatasetOutput::finish(const std::function<void(double fraction)>& progress) {
  if (temporary_) upload_file(file_, output_.string(), condition_, {}, progress);
}

fs::path scratch_folder(const fs::path& output) {
  return is_address(output.string()) ? fs::temp_directory_path() : output;
}

}  // namespace multitetra
