// From the types that samples have in files to those that they have in memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>

#include "server/core/framework/volume.hpp"
#include "server/dataset/image_file.hpp"

namespace multitetra {

// The type that samples of `stored` have in memory: their own where SampleType has it, else f32.
[[nodiscard]] SampleType type_in_memory(StoredType stored);
[[nodiscard]] bool is_converted(StoredType stored);

// Makes room for `count` samples of `type`. What `samples` held is lost; its memory is used again
// when it is of the same type.
void resize(Samples& samples, SampleType type, std::size_t count);
// The first byte of the samples.
[[nodiscard]] std::byte* bytes_of(Samples& samples);

// Samples of a type that memory does not have become f32. Requires is_converted(stored) and that
// `bytes` holds into.size() samples.
void convert(StoredType stored, const std::byte* bytes, std::span<float> into);

// Infinity is no place on a surface's way: such samples become void (NaN). Returns how many.
std::uint64_t make_infinite_void(std::span<float> samples);

// Tell what happened to samples, if anything did and there is someone to tell.
using Notice = std::function<void(const std::string&)>;
void tell_conversion(const Notice& notice, const std::filesystem::path& file, StoredType stored);
void tell_infinite(const Notice& notice, const std::filesystem::path& file, std::uint64_t infinite);

}  // namespace multitetra
