// Selects and names the datasets for the labels of a segmentation.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "server/programs/prepare/prepare_run.hpp"

namespace multitetra {

inline constexpr std::size_t kMaxLabelsAtOnce = 1024;  // Limit for --label all.

// Labels are sample values. But if the source's segments are in several layers and no component is
// chosen, they are segment numbers.
class LabelJobs {
 public:
  // `named` has the labels of the source, whose first volume is `input`; --label-names adds or
  // overrides labels. Throws VolumeFileError if that file cannot be read. Keeps references to
  // arguments and maps.
  LabelJobs(const PrepareArguments& arguments, LatestLabelMap& maps, const std::string& input,
            std::vector<SourceLabel> named);

  // Returns a notice about the numbers of labels; may be empty.
  [[nodiscard]] const std::string& notice() const { return notice_; }

  // Returns a job for each selected label of a volume, grouped by map, or one for the volume itself
  // without labels. Reads the volume for --label all. Throws ExitError (kUsage) if a selected label
  // is missing, VolumeFileError if the volume cannot be read.
  [[nodiscard]] std::vector<PrepareJob> of(const PrepareJob& volume) const;

 private:
  [[nodiscard]] std::vector<PrepareJob> of_map(const PrepareJob& volume) const;
  [[nodiscard]] std::vector<PrepareJob> of_layers(const PrepareJob& volume) const;
  // Returns the segments selected by --label.
  [[nodiscard]] std::vector<SourceLabel> wanted_segments(const std::string& input) const;
  [[nodiscard]] Label label_of(double value, int layer) const;
  [[nodiscard]] Label renamed(const Label& label) const;
  [[nodiscard]] std::vector<double> found_in(const PrepareJob& volume) const;

  const PrepareArguments& arguments_;
  LatestLabelMap& maps_;
  std::vector<SourceLabel> named_;
  bool has_layers_ = false;
  std::string notice_;
  // Names from --label-names, by label.
  std::map<double, Label> renamed_;
};

}  // namespace multitetra
