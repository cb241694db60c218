// A Zarr or N5 hierarchy as a container of arrays.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "server/store/object_store.hpp"
#include "server/volume/formats/arrays/array_container.hpp"
#include "server/volume/formats/zarr/detail/chunked_array.hpp"

namespace multitetra {

class ZarrContainer : public ArrayContainer {
 public:
  explicit ZarrContainer(std::shared_ptr<ObjectStore> store) : store_(std::move(store)) {}

  [[nodiscard]] const std::shared_ptr<ObjectStore>& store() const { return store_; }

  // Returns the user's attributes of a group or array; not an object if there are none.
  [[nodiscard]] const nlohmann::json& attributes(const std::string& path) const;
  // Returns the layout of an array, or nullopt if there is none. Throws VolumeFileError for arrays
  // that are not supported.
  [[nodiscard]] std::optional<ArrayLayout> layout(const std::string& path) const;

  // Why the first array was left out that has a type or a codec which is not read; empty if none
  // was, so far.
  [[nodiscard]] const std::string& unsupported() const { return unsupported_; }

  // Arrays by consolidated metadata, or else by listing folders, which servers cannot do.
  [[nodiscard]] std::vector<std::string> arrays() const override;
  [[nodiscard]] std::vector<std::string> children(const std::string& group) const override;
  [[nodiscard]] std::filesystem::path file() const override { return store_->place(""); }
  [[nodiscard]] std::vector<std::int64_t> shape(const std::string& array) const override;
  [[nodiscard]] std::optional<StoredType> type(const std::string& array) const override;
  [[nodiscard]] std::vector<double> values(const std::string& array) const override;
  [[nodiscard]] std::vector<double> numbers(const std::string& object,
                                            const char* attribute) const override;
  [[nodiscard]] std::vector<std::string> texts(const std::string& object,
                                               const char* attribute) const override;
  [[nodiscard]] std::vector<std::string> dimension_names(const std::string& array) const override;
  [[nodiscard]] std::string coordinates(const std::string& array,
                                        std::size_t dimension) const override;

 private:
  [[nodiscard]] std::optional<std::string> text_at(const std::string& key) const;
  [[nodiscard]] nlohmann::json json_at(const std::string& key) const;
  void find_arrays(const std::string& group, int depth, std::vector<std::string>& found) const;

  std::shared_ptr<ObjectStore> store_;
  mutable std::string unsupported_;
  mutable std::map<std::string, nlohmann::json> attributes_;  // By path, as read.
};

// "a/b" -> "a/b/"; "" and "/" stay empty: what keys of the objects of a group begin with.
[[nodiscard]] std::string key_prefix_of(const std::string& path);

}  // namespace multitetra
