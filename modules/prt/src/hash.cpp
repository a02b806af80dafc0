#include <alpenglow/prt/hash.hpp>

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace alpenglow::prt {

struct Hasher::State {
    XXH3_state_t xxh;
};

Hasher::Hasher() : state_(std::make_unique<State>()) {
    XXH3_64bits_reset(&state_->xxh);
}
Hasher::~Hasher() = default;

void Hasher::add(std::span<const std::byte> bytes) {
    if (!bytes.empty()) {
        XXH3_64bits_update(&state_->xxh, bytes.data(), bytes.size());
    }
}

std::uint64_t Hasher::digest() const {
    return XXH3_64bits_digest(&state_->xxh);
}

} // namespace alpenglow::prt
