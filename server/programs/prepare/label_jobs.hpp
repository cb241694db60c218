// The datasets of the labels of a segmentation, and their names.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "server/programs/prepare/prepare_run.hpp"

namespace multitetra {

inline constexpr std::size_t kMostLabelsAtOnce = 1024;  // The most datasets of --label all.

// Labels are the numbers that samples have, unless the source's segments lie in several layers and
// no component is chosen: then they are the segments' numbers.
class LabelJobs {
 public:
  // `named` are the source's labels, of which `input` is the first volume; --label-names adds to
  // them or overrides them. Throws VolumeFileError when its file cannot be read. Keeps references
  // to arguments and maps.
  LabelJobs(const PrepareArguments& arguments, LatestLabelMap& maps, const std::string& input,
            std::vector<SourceLabel> named);

  // A notice about the labels' numbers; may be empty.
  [[nodiscard]] const std::string& notice() const { return notice_; }

  // A job for each selected label of a volume; the volume itself without labels. Those of
  // one map follow each other. Reads the volume for --label all. Throws ExitError (kUsage) when
  // a selected label is missing, VolumeFileError when the volume cannot be read.
  [[nodiscard]] std::vector<PrepareJob> of(const PrepareJob& volume) const;

 private:
  [[nodiscard]] std::vector<PrepareJob> of_map(const PrepareJob& volume) const;
  [[nodiscard]] std::vector<PrepareJob> of_layers(const PrepareJob& volume) const;
  // The segments of --label, which are all or some of those that there are.
  [[nodiscard]] std::vector<SourceLabel> wanted_segments(const std::string& input) const;
  [[nodiscard]] Label label_of(double value, int layer) const;
  [[nodiscard]] Label renamed(const Label& label) const;
  [[nodiscard]] std::vector<double> found_in(const PrepareJob& volume) const;

  const PrepareArguments& arguments_;
  LatestLabelMap& maps_;
  std::vector<SourceLabel> named_;
  bool has_layers_ = false;
  std::string notice_;
  // From --label-names.
  std::map<double, Label> renamed_;
};

}  // namespace multitetra
