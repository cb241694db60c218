// The volumes that `prepare` turns into datasets, and those that are up to date.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/request/series_member.hpp"
#include "server/dataset/provenance.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

struct PrepareJob {
  std::string input;
  std::filesystem::path output;
  // The dataset's name.
  std::string name;
  // The volume of the input.
  VolumeChoice choice = {};
  std::optional<SeriesMember> member = std::nullopt;
  double stored_label = 0;                     // The value of the label's samples in the label map.
  std::vector<std::string> command_line = {};  // The options that choose a member: "--time 3".
};

// A source's name without its folder and suffixes: "chris_t1.nii.gz" is chris_t1.
[[nodiscard]] std::string default_dataset_name(const std::filesystem::path& input);

// The number of a label: "3".
[[nodiscard]] std::string label_text(const Label& label);

// Whether the inputs are more than one volume: several, or a folder that is none itself.
[[nodiscard]] bool has_several_volumes(const std::vector<std::string>& inputs);

// A job for every volume; datasets go into `folder`, each under a name of its own.
[[nodiscard]] std::vector<PrepareJob> jobs_for(const std::vector<std::string>& inputs,
                                               const std::filesystem::path& folder);

// Whether the job's dataset is there, whole, under its name, what it is in its series, and made
// from the source and options in `note`. Data files that a header names are not in its
// digest, so the dataset must also be newer than all files beside the source. No for one in a
// bucket.
[[nodiscard]] bool is_up_to_date(const PrepareJob& job, const Provenance& note);

}  // namespace multitetra
