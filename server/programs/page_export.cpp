#include "server/programs/page_export.hpp"

#include <set>
#include <stdexcept>

#include "common/base/json.hpp"
#include "common/base/open_file.hpp"
#include "common/base/percent_encoded.hpp"
#include "common/json/json_report.hpp"
#include "common/wire/mesh_files.hpp"
#include "server/dataset/dataset.hpp"
#include "server/dataset/prepared_file.hpp"
#include "server/routes/viewer_files.hpp"
#include "server/store/http_options.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

constexpr const char* kIndex = "datasets.json";
constexpr int kIndexVersion = 1;
constexpr const char* kMark =
    "multitetra-static";  // In the index.html of such pages, and no other.

std::string content(const fs::path& file) {
  auto bytes = OpenFile(file).content(SIZE_MAX);
  if (!bytes) throw std::runtime_error("Cannot read '" + file.string() + "'.");
  return *std::move(bytes);
}

class PageWriter {
 public:
  // Throws if the folder has files that would be lost. A page that was exported is replaced.
  explicit PageWriter(fs::path folder) : folder_(std::move(folder)) {
    const fs::path page = folder_ / "index.html";
    is_replaced_ = fs::exists(page) && content(page).find(kMark) != std::string::npos;
    require_free(page);
    require_free(folder_ / kIndex);
  }

  [[nodiscard]] const ExportedPage& exported() const { return exported_; }

  // Web spaces compress files themselves, so the compressed copies are left out.
  void write_viewer(const fs::path& viewer) {
    for (const auto& entry : fs::recursive_directory_iterator(viewer)) {
      const fs::path name = entry.path().lexically_relative(viewer);
      if (!entry.is_regular_file() || name.extension() == ".gz" || name.extension() == ".br")
        continue;
      write(name, name == "index.html" ? with_index(content(entry.path())) : content(entry.path()));
    }
  }

  // `name` is the file's in the page.
  void add_dataset(const std::string& file, const fs::path& name) {
    const PreparedFile prepared(file);
    if (!names_.insert(prepared.info().name).second) {
      throw std::runtime_error("Two datasets are named \"" + prepared.info().name +
                               "\"; prepare one with another --name.");
    }
    const fs::path target = folder_ / name;
    fs::create_directories(target.parent_path());
    if (!fs::exists(target) || !fs::equivalent(file, target)) {
      require_free(target);
      fs::copy_file(file, target, fs::copy_options::overwrite_existing);
    }
    index_.push_back({{"file", percent_encoded(name.generic_string(), "/")},
                      {"metadata", parse_json(metadata_text(prepared.metadata()))}});
    ++exported_.datasets;
    count(prepared.bytes());
  }

  void write_index() {
    write(kIndex, text_of(Json{{"version", kIndexVersion}, {"datasets", index_}}));
  }

 private:
  // Names the index in the page.
  static std::string with_index(std::string page) {
    const std::string head = "<head>";
    const std::size_t at = page.find(head);
    if (at == std::string::npos) throw std::runtime_error("The viewer's index.html has no <head>.");
    return page.insert(at + head.size(), "\n    <meta name=\"" + std::string(kMark) +
                                             "\" content=\"" + kIndex + "\" />");
  }

  void require_free(const fs::path& target) const {
    if (is_replaced_ || !fs::exists(target)) return;
    throw std::runtime_error("'" + target.string() +
                             "' exists, and its folder has no exported page; name another folder.");
  }

  void write(const fs::path& name, const std::string& bytes) {
    fs::create_directories((folder_ / name).parent_path());
    write_file(folder_ / name, bytes);
    count(bytes.size());
  }

  void count(std::uint64_t bytes) {
    ++exported_.files;
    exported_.bytes += bytes;
  }

  fs::path folder_;
  bool is_replaced_ = false;
  std::set<std::string> names_;
  Json index_ = Json::array();
  ExportedPage exported_;
};

}  // namespace

ExportedPage export_page(const std::string& datasets, const std::filesystem::path& folder) {
  if (is_address(datasets)) {
    throw std::runtime_error("A page is made of files on this machine; download " + datasets +
                             " first.");
  }
  const fs::path viewer = viewer_folder();
  if (viewer.empty()) {
    throw std::runtime_error("The browser viewer is not installed, so there is no page to write.");
  }
  PageWriter page(folder);
  if (is_folder_of_datasets(datasets)) {
    for (const std::string& file : datasets_in(datasets)) {
      page.add_dataset(file, fs::path(file).lexically_relative(datasets));
    }
  } else {
    page.add_dataset(datasets, fs::path(datasets).filename());
  }
  if (page.exported().datasets == 0) {
    throw std::runtime_error("There is no dataset in " + datasets + ".");
  }
  page.write_viewer(viewer);
  page.write_index();
  return page.exported();
}

}  // namespace multitetra
