// This file includes the concept alone: it must stand without our registry, as in a game on EnTT.
#include <alpenglow/ecs/registry_concept.hpp>

#include <cstdint>

namespace {

struct NotARegistry {
    using entity_type = std::uint32_t;
    entity_type create();
    void destroy(entity_type);
    bool valid(entity_type) const;
};

static_assert(!alpenglow::Registry<NotARegistry>);
static_assert(!alpenglow::Registry<int>);

} // namespace
