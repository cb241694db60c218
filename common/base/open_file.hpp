// An open file: closed by its destructor, read and written at any offset.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>

namespace multitetra {

// Functions that fail leave the reason in errno. Reading and writing are safe from several threads
// at once.
class OpenFile {
 public:
  OpenFile() = default;
  // Takes a descriptor from open(2); negative if that failed.
  explicit OpenFile(int descriptor) : descriptor_(descriptor) {}
  // Opens a file for reading. Opening a named pipe does not wait for a writer.
  explicit OpenFile(const std::filesystem::path& file);
  OpenFile(OpenFile&& other) noexcept;
  OpenFile& operator=(OpenFile&& other) noexcept;
  ~OpenFile();

  [[nodiscard]] bool is_open() const { return descriptor_ >= 0; }
  [[nodiscard]] int descriptor() const { return descriptor_; }
  // Returns false for errors that are found only now, such as a full disk on a network.
  bool close();
  // Locks the whole file (flock). Returns false if that fails, or would have to wait.
  [[nodiscard]] bool lock(int kind) const;

  // Returns nullopt unless it is a regular file.
  [[nodiscard]] std::optional<std::uint64_t> regular_size() const;
  // Returns the number of bytes read, which is smaller than requested only at the end of the file.
  [[nodiscard]] std::optional<std::size_t> read_some(std::uint64_t offset,
                                                     std::span<std::byte> into) const;
  // Reads like read_some(), but a file that ends too early is an error (EIO).
  [[nodiscard]] bool read(std::uint64_t offset, std::span<std::byte> into) const;
  // Returns the content, or its first `max_bytes` bytes.
  [[nodiscard]] std::optional<std::string> content(std::size_t max_bytes) const;
  [[nodiscard]] bool write(std::uint64_t offset, std::span<const std::byte> bytes) const;

 private:
  int descriptor_ = -1;
};

}  // namespace multitetra
