#include "server/volume/formats/image_stack.hpp"

#include <algorithm>
#include <cstddef>
#include <functional>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "common/base/natural_order.hpp"
#include "common/base/number_text.hpp"
#include "common/base/text.hpp"
#include "server/volume/formats/detail/input_file.hpp"
#include "server/volume/formats/jpeg_file.hpp"
#include "server/volume/formats/png_file.hpp"
#include "server/volume/formats/tiff_file.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

// A printf conversion of an integer at the start of `text`: '%', digits, 'd'.
struct Conversion {
  // Length of the conversion's text; 0 if there is none.
  std::size_t length = 0;
  std::size_t min_width = 1;  // Minimum number of digits that it prints.
};

Conversion conversion_at(std::string_view text) {
  if (text.empty() || text[0] != '%') return {};
  const std::size_t digits = digits_at(text, 1);
  if (digits > 2 || 1 + digits >= text.size() || text[1 + digits] != 'd') return {};
  const std::string width(text.substr(1, digits));
  return {.length = digits + 2, .min_width = width.empty() ? 1 : std::stoul(width)};
}

// Returns whether `name` matches `pattern`: '*' matches any characters, '?' any one, a conversion a
// run of digits, any other character itself.
bool matches(std::string_view pattern, std::string_view name) {
  if (pattern.empty()) return name.empty();
  if (pattern[0] == '*') {
    for (std::size_t skipped = 0; skipped <= name.size(); ++skipped) {
      if (matches(pattern.substr(1), name.substr(skipped))) return true;
    }
    return false;
  }
  if (const Conversion conversion = conversion_at(pattern); conversion.length > 0) {
    const std::size_t digits = digits_at(name, 0);
    return digits >= conversion.min_width && digits > 0 &&
           matches(pattern.substr(conversion.length), name.substr(digits));
  }
  return !name.empty() && (pattern[0] == '?' || pattern[0] == name[0]) &&
         matches(pattern.substr(1), name.substr(1));
}

bool is_png(const fs::path& file) { return lower_case(file.extension().string()) == ".png"; }

bool is_jpeg(const fs::path& file) {
  const std::string suffix = lower_case(file.extension().string());
  return suffix == ".jpg" || suffix == ".jpeg";
}

bool is_tiff(const fs::path& file) {
  const std::string suffix = lower_case(file.extension().string());
  return suffix == ".tif" || suffix == ".tiff";
}

StoredVolume open_slice(const fs::path& file) {
  // Recognizes images by content, since the name is arbitrary; damaged ones by name.
  const std::string begin = InputFile(file).beginning(4);
  if (begin.starts_with("\xFF\xD8\xFF")) return open_jpeg(file);
  if (begin.starts_with("\x89PNG") || is_png(file)) return open_png(file);
  return is_jpeg(file) ? open_jpeg(file) : open_tiff_slice(file);
}

std::string size_and_type(const ImageHeader& image) {
  return sides_text(image.dims) + " samples of " + std::to_string(bytes_of(image.type)) + " bytes";
}

// ---- gaps in the numbers of the files

// A file name: its numbers, and the text around them with '#' in place of each.
struct NumberedName {
  std::string text;
  std::vector<std::int64_t> numbers;
};

NumberedName numbered_name_of(const fs::path& file) {
  constexpr std::size_t kMaxDigits = 18;
  const std::string name = file.filename().string();
  NumberedName result;
  for (std::size_t at = 0; at < name.size();) {
    const std::size_t digits = digits_at(name, at);
    const std::size_t as_text = digits == 0 ? 1 : digits - std::min(digits, kMaxDigits);
    result.text += name.substr(at, as_text);
    if (digits > 0) {
      result.text += '#';
      result.numbers.push_back(std::stoll(name.substr(at + as_text, digits - as_text)));
    }
    at += std::max<std::size_t>(digits, 1);
  }
  return result;
}

// Returns the numbers that are missing between the first and the last, in steps of the most common
// difference; at most kMaxListed + 1 of them.
constexpr std::size_t kMaxListed = 20;
std::vector<std::int64_t> missing_in(const std::set<std::int64_t>& numbers) {
  std::map<std::int64_t, std::size_t> steps;
  for (auto at = numbers.begin(); std::next(at) != numbers.end(); ++at) {
    ++steps[*std::next(at) - *at];
  }
  const std::int64_t step = std::ranges::max_element(steps, {}, [](const auto& counted) {
                              return counted.second;
                            })->first;
  std::vector<std::int64_t> missing;
  for (auto at = numbers.begin(); std::next(at) != numbers.end(); ++at) {
    for (std::int64_t number = *at + step; number < *std::next(at); number += step) {
      if (missing.size() > kMaxListed) return missing;
      missing.push_back(number);
    }
  }
  return missing;
}

// Returns notices of files that numbers in the names suggest: missing ones, or several volumes.
std::vector<std::string> numbering_notices(const fs::path& path,
                                           const std::vector<fs::path>& files) {
  std::vector<std::set<std::int64_t>> numbers;
  std::map<std::string, std::vector<fs::path>> kinds;  // By the text around the numbers.
  for (const fs::path& file : files) kinds[numbered_name_of(file).text].push_back(file);
  if (kinds.size() > 1) {
    if (kinds.size() == files.size()) return {};  // The files are not numbered.
    return {"'" + path.string() + "': the names of its images are of " +
            std::to_string(kinds.size()) + " kinds, such as '" +
            kinds.begin()->second.front().filename().string() + "' and '" +
            kinds.rbegin()->second.front().filename().string() +
            "'; all are slices of one volume. Give a pattern for the images of one."};
  }
  for (const fs::path& file : files) {
    const NumberedName name = numbered_name_of(file);
    numbers.resize(name.numbers.size());
    for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i].insert(name.numbers[i]);
  }
  std::erase_if(numbers, [](const auto& of_place) { return of_place.size() < 2; });
  std::size_t product = 1;
  for (const auto& of_place : numbers) product *= std::min(of_place.size(), files.size());
  if (numbers.size() == 2 && product == files.size()) {
    return {"'" + path.string() + "': the names of its images have two numbers, " +
            std::to_string(numbers[0].size()) + " by " + std::to_string(numbers[1].size()) +
            ", as for several channels or times; all are slices of one volume. Give a pattern for "
            "the images of one."};
  }
  if (numbers.size() == 1 && numbers[0].size() < files.size()) {
    return {"'" + path.string() +
            "': some of its images have the same number; all are slices of one volume."};
  }
  // Of several numbers that differ from image to image, the most even and densest count them.
  std::erase_if(numbers, [&](const auto& of_place) { return of_place.size() != files.size(); });
  if (numbers.empty()) return {};
  const auto unevenness = [](const std::set<std::int64_t>& of_place) {
    return std::pair(missing_in(of_place).size(), *of_place.rbegin() - *of_place.begin());
  };
  const std::vector<std::int64_t> missing =
      missing_in(*std::ranges::min_element(numbers, {}, unevenness));
  if (missing.empty()) return {};
  std::string list;
  for (std::size_t i = 0; i < std::min(missing.size(), kMaxListed); ++i) {
    list += (i == 0 ? "" : ", ") + std::to_string(missing[i]);
  }
  if (missing.size() > kMaxListed) list += " and more";
  return {"'" + path.string() + "': in the numbers of its images, " + list +
          (missing.size() == 1 ? " is" : " are") + " missing; the slices of its " +
          std::to_string(files.size()) + " images follow each other without a gap."};
}

// ---- reading

class StackSlices : public StoredSlices {
 public:
  StackSlices(std::vector<fs::path> files, const ImageHeader& first)
      : files_(std::move(files)), first_(first) {}

  void read(std::size_t first, std::size_t count, std::byte* into) override {
    for (std::size_t i = 0; i < count; ++i) {
      read_image(files_[first + i], into + i * first_.slice_bytes());
    }
  }

 private:
  void read_image(const fs::path& file, std::byte* into) const {
    const StoredVolume image = open_slice(file);
    if (image.header.dims != first_.dims || image.header.type != first_.type ||
        image.header.components != first_.components) {
      fail_reading(file,
                   "it has " + size_and_type(image.header) +
                       ", but the first image of the stack, '" + files_.front().string() +
                       "', has " + size_and_type(first_),
                   "All images of a stack must have the same size and type");
    }
    image.slices->read(0, 1, into);
  }

  std::vector<fs::path> files_;
  ImageHeader first_;
};

}  // namespace

bool is_stack_pattern(std::string_view file_name) {
  for (std::size_t at = 0; at < file_name.size(); ++at) {
    if (file_name[at] == '*' || file_name[at] == '?') return true;
    if (conversion_at(file_name.substr(at)).length > 0) return true;
  }
  return false;
}

std::vector<fs::path> matching_files(const fs::path& path) {
  std::error_code error;
  const bool is_directory = fs::is_directory(path, error);
  const std::string pattern = is_directory ? "*" : path.filename().string();
  fs::path directory = is_directory ? path : path.parent_path();
  if (directory.empty()) directory = ".";

  std::vector<fs::path> files;
  for (fs::directory_iterator entry(directory, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string file_name = entry->path().filename().string();
    std::error_code ignored;
    if (file_name.starts_with('.') || entry->is_directory(ignored)) continue;
    if (matches(pattern, file_name)) files.push_back(entry->path());
  }
  std::sort(files.begin(), files.end(), [](const fs::path& a, const fs::path& b) {
    return natural_order_less(a.filename().string(), b.filename().string());
  });
  return files;
}

std::vector<fs::path> stack_files(const fs::path& path) {
  std::vector<fs::path> files = matching_files(path);
  std::erase_if(files, [](const fs::path& file) {
    return !is_tiff(file) && !is_png(file) && !is_jpeg(file);
  });
  // Keeps the preferred format; images in other formats are previews.
  const auto has = [&](bool (*is_kind)(const fs::path&)) {
    return std::any_of(files.begin(), files.end(), is_kind);
  };
  if (has(is_tiff)) std::erase_if(files, std::not_fn(is_tiff));
  if (has(is_png)) std::erase_if(files, std::not_fn(is_png));
  return files;
}

StoredVolume open_image_stack(const fs::path& path) {
  std::error_code error;
  std::vector<fs::path> files = stack_files(path);
  if (files.empty() && fs::is_regular_file(path, error)) files = {path};
  if (files.empty()) {
    fail_reading(path,
                 "there are no TIFF, PNG or JPEG images in this folder or matching this pattern",
                 "Give a folder with images, or a pattern such as slice%03d.tif");
  }
  const StoredVolume first = open_slice(files.front());
  if (first.header.dims[2] != 1) {
    fail_reading(files.front(), "it has " + std::to_string(first.header.dims[2]) + " images",
                 "The files of a stack must have one image each; give this file alone");
  }
  ImageHeader stack = first.header;
  stack.dims[2] = static_cast<std::int64_t>(files.size());
  check_header(path, stack);
  std::vector<std::string> notices = numbering_notices(path, files);
  notices.insert(notices.end(), first.notices.begin(), first.notices.end());
  return {.header = stack,
          .slices = std::make_unique<StackSlices>(std::move(files), first.header),
          .notices = std::move(notices)};
}

}  // namespace multitetra
