// Which volumes `prepare` makes datasets of, and which of them are made already.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "server/dataset/source_note.hpp"

namespace multitetra {

struct PrepareJob {
  std::string input;
  std::filesystem::path output;
  std::string name;  // Of the dataset.
};

// A source's name without its folder and suffixes: "chris_t1.nii.gz" is chris_t1.
[[nodiscard]] std::string default_dataset_name(const std::filesystem::path& input);

// Whether the inputs are more than one volume: several, or a folder that is none itself.
[[nodiscard]] bool are_many(const std::vector<std::string>& inputs);

// A job for every volume; datasets go into `folder`, each under a name of its own.
[[nodiscard]] std::vector<PrepareJob> jobs_for(const std::vector<std::string>& inputs,
                                               const std::filesystem::path& folder);

// Whether the job's dataset is there, whole, and made from a source and with options that `note`
// tells. Data files that a header names are not in its digest, so the dataset must also be newer
// than all files beside the source.
[[nodiscard]] bool is_up_to_date(const PrepareJob& job, const SourceNote& note);

}  // namespace multitetra
