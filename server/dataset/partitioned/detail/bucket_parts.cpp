#include "server/dataset/partitioned/detail/bucket_parts.hpp"

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "server/dataset/partitioned/detail/part_files.hpp"
#include "server/dataset/partitioned/part_plan.hpp"
#include "server/store/bucket.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

// "s3://bucket/big.mtd.parts/": an fs::path would not keep both slashes everywhere.
std::string folder_of(const std::string& dataset) { return dataset + ".parts/"; }

std::string plan_of_bucket(const std::string& dataset) {
  return folder_of(dataset) + plan_file(dataset).filename().string();
}

std::string name_in(std::string_view address) {
  return std::string(address.substr(address.rfind('/') + 1));
}

}  // namespace

BucketParts::BucketParts(const fs::path& dataset)
    : dataset_(dataset.string()), file_(folder_.path() / name_in(dataset_)) {
  fs::create_directory(parts_folder(file_));
}

void BucketParts::fetch_plan() const {
  if (!download_file(plan_of_bucket(dataset_), plan_file(file_))) fail_without_plan(dataset_);
}

void BucketParts::fetch_parts() const {
  for (const std::string& address : list_bucket(folder_of(dataset_), "")) {
    const fs::path file = parts_folder(file_) / name_in(address);
    if (is_part_file(file)) download_file(address, file);
  }
}

void BucketParts::send(const fs::path& file) const {
  upload_file(file, folder_of(dataset_) + file.filename().string(),
              {.kind = UploadCondition::Kind::kAny});
}

std::string BucketParts::with_addresses(std::string text) const {
  const std::string local = file_.string();
  for (std::size_t at = 0; (at = text.find(local, at)) != std::string::npos;) {
    text.replace(at, local.size(), dataset_);
    at += dataset_.size();
  }
  return text;
}

void BucketParts::send_plan() const { send(plan_file(file_)); }

void BucketParts::send_part(std::size_t part) const {
  for (const std::string_view suffix : kPartSuffixes) send(part_file(file_, part, suffix));
}

void BucketParts::finish() const {
  const auto existing = find_object(dataset_, 1);
  upload_file(file_, dataset_,
              existing ? UploadCondition{.kind = UploadCondition::Kind::kSameVersion,
                                         .etag = existing->etag}
                       : UploadCondition{});
  std::vector<std::string> parts;
  for (const std::string& address : list_bucket(folder_of(dataset_), "")) {
    if (is_part_file(name_in(address))) parts.push_back(address);
  }
  parts.push_back(plan_of_bucket(dataset_));
  for (const std::string& address : parts) remove_object(address);
}

}  // namespace multitetra
