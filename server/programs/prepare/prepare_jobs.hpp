// The volumes that `prepare` converts to datasets, and whether they are up to date.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/dataset/series_member.hpp"
#include "server/dataset/provenance.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

struct PrepareJob {
  std::string input;
  std::filesystem::path output;
  std::string name;
  VolumeChoice choice = {};
  std::optional<SeriesMember> member = std::nullopt;
  double stored_label = 0;                              // The label's value in the label map.
  std::optional<double> collected_time = std::nullopt;  // In the .pvd file that lists the input.
  std::vector<std::string> command_line = {};  // Options that select the member: "--time 3".
};

// Returns the number of a label, such as "3".
[[nodiscard]] std::string label_text(const Label& label);

// Returns whether a place is a dataset, so that preparing it means to compute missing errors.
[[nodiscard]] bool is_dataset_file(const std::string& place);

// Returns whether the inputs are several volumes: more than one, or a folder that is not itself a
// volume.
[[nodiscard]] bool has_several_volumes(const std::vector<std::string>& inputs);

// Returns a job for every volume; .pvd files stand for those that they list. Datasets get unique
// names in `folder`. Throws ExitError (kUsage)
// if there is no volume.
[[nodiscard]] std::vector<PrepareJob> jobs_for(const std::vector<std::string>& inputs,
                                               const std::filesystem::path& folder,
                                               bool allow_external_files = false);

// Returns whether the job's dataset exists, is complete, and has the same name, series member,
// source and options as the job and `note`. The source's digest does not cover data files named by
// a header, so the dataset must also be newer than all other files in the source's folder. Always
// false for datasets in a bucket.
[[nodiscard]] bool is_up_to_date(const PrepareJob& job, const Provenance& note);

}  // namespace multitetra
