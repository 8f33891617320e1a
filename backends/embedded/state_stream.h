#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/errors.h"

namespace powdercal::embedded {

// The bytes of a simulation's state, for going on in another process of the same kind of machine:
// numbers as they lie in memory. A class says what its state is in one template for both
// directions,
//
//   template <typename Self, typename Stream>
//   static void Transfer(Self& self, Stream& stream) { stream(self.a_, self.b_); }

class StateWriter;

template <typename T>
concept HasTransfer = requires(const T& value, StateWriter& stream) {
  T::Transfer(value, stream);
};

class StateWriter {
 public:
  template <typename... T>
  void operator()(const T&... values) {
    (Write(values), ...);
  }
  std::string Take() { return std::move(bytes_); }

 private:
  template <typename T>
  void Write(const T& value) {
    if constexpr (HasTransfer<T>) {
      T::Transfer(value, *this);
    } else {
      static_assert(std::is_trivially_copyable_v<T>);
      Append(&value, sizeof value);
    }
  }
  template <typename T, typename Allocator>
  void Write(const std::vector<T, Allocator>& values) {
    Write(static_cast<std::uint64_t>(values.size()));
    if constexpr (std::is_trivially_copyable_v<T> && !HasTransfer<T>) {
      Append(values.data(), values.size() * sizeof(T));
    } else {
      for (const T& value : values) Write(value);
    }
  }
  template <typename T, std::size_t n>
  void Write(const std::array<T, n>& values) {
    for (const T& value : values) Write(value);
  }
  template <typename T, typename U>
  void Write(const std::pair<T, U>& value) {
    Write(value.first);
    Write(value.second);
  }
  template <typename T>
  void Write(const std::optional<T>& value) {
    Write(value.has_value());
    if (value) Write(*value);
  }
  void Append(const void* data, std::size_t size) {
    if (size > 0) bytes_.append(static_cast<const char*>(data), size);
  }

  std::string bytes_;
};

/// Reads what a StateWriter wrote. Throws InputError where bytes are missing.
class StateReader {
 public:
  explicit StateReader(std::string_view bytes) : bytes_(bytes) {}

  template <typename... T>
  void operator()(T&... values) {
    (Read(values), ...);
  }
  bool at_end() const { return bytes_.empty(); }

 private:
  template <typename T>
  void Read(T& value) {
    if constexpr (HasTransfer<T>) {
      T::Transfer(value, *this);
    } else {
      static_assert(std::is_trivially_copyable_v<T>);
      Extract(&value, sizeof value);
    }
  }
  template <typename T, typename Allocator>
  void Read(std::vector<T, Allocator>& values) {
    std::uint64_t size = 0;
    Read(size);
    if constexpr (std::is_trivially_copyable_v<T> && !HasTransfer<T>) {
      if (size > bytes_.size() / sizeof(T)) TooShort();
      values.resize(size);
      Extract(values.data(), size * sizeof(T));
    } else {
      if (size > bytes_.size()) TooShort();
      values.resize(size);
      for (T& value : values) Read(value);
    }
  }
  template <typename T, std::size_t n>
  void Read(std::array<T, n>& values) {
    for (T& value : values) Read(value);
  }
  template <typename T, typename U>
  void Read(std::pair<T, U>& value) {
    Read(value.first);
    Read(value.second);
  }
  template <typename T>
  void Read(std::optional<T>& value) {
    bool has_value = false;
    Read(has_value);
    value.reset();
    if (has_value) Read(value.emplace());
  }
  [[noreturn]] static void TooShort() {
    throw InputError("the saved state is shorter than it says");
  }
  void Extract(void* data, std::size_t size) {
    if (size > bytes_.size()) TooShort();
    if (size > 0) std::memcpy(data, bytes_.data(), size);
    bytes_.remove_prefix(size);
  }

  std::string_view bytes_;
};

}  // namespace powdercal::embedded
