// XXH3, 64 bits: content hashes and file checksums.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

namespace alpenglow::prt {

class Hasher {
public:
    Hasher();
    ~Hasher();
    Hasher(const Hasher&) = delete;
    Hasher& operator=(const Hasher&) = delete;

    void add(std::span<const std::byte> bytes);
    template <class T>
    void add_values(std::span<const T> values) {
        const std::uint64_t count = values.size();
        add(std::as_bytes(std::span(&count, 1)));
        add(std::as_bytes(values));
    }
    [[nodiscard]] std::uint64_t digest() const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace alpenglow::prt
