// tests/support/file_bytes.h: the bytes of files, to compare, to damage and to replace.
#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace plait::test {

inline std::string content_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

/// Writes the file anew in place: its other names have the same bytes.
inline void write_content(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

/// Changes bits of a byte in place.
inline void flip_byte(const std::filesystem::path& path, std::streamoff offset, int bits = 0x20) {
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.seekg(offset);
  const int byte = file.get();
  file.seekp(offset);
  file.put(static_cast<char>(byte ^ bits));
}

/// Changes a bit of a byte in a file of its own: what had other names keeps the former bytes there.
inline void damage_own(const std::filesystem::path& path, std::size_t at) {
  std::string bytes = content_of(path);
  bytes.at(at) = static_cast<char>(bytes.at(at) ^ 1);
  std::filesystem::remove(path);
  write_content(path, bytes);
}

}  // namespace plait::test
