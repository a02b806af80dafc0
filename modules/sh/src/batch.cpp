#include <alpenglow/sh/batch.hpp>

#include <hwy/aligned_allocator.h>
#include <hwy/highway.h>

#include <algorithm>

namespace alpenglow::sh {

BatchBuffer::BatchBuffer(std::size_t rows, std::size_t count)
    : rows_(rows), count_(count),
      // An odd number of cache lines, so that the rows of one item fall into different sets of the cache.
      stride_((std::max<std::size_t>(padded(count), batch_group) / batch_group | 1U) * batch_group),
      data_(static_cast<float*>(
          hwy::AllocateAlignedBytes(std::max<std::size_t>(rows, 1) * stride_ * sizeof(float), nullptr, nullptr))) {
    std::fill_n(data_.get(), std::max<std::size_t>(rows, 1) * stride_, 0.0F);
}

void BatchBuffer::Free::operator()(float* p) const noexcept {
    hwy::FreeAlignedBytes(p, nullptr, nullptr);
}

const char* batch_target_name() {
    const int64_t targets = hwy::SupportedTargets() & (HWY_TARGETS);
    return hwy::TargetName(targets & -targets); // the lowest bit is the best target
}

bool limit_batch_target(BatchTarget target) {
    int64_t wanted = 0;
    switch (target) {
    case BatchTarget::scalar:
        wanted = HWY_STATIC_TARGET;
        break;
#if HWY_ARCH_X86
    case BatchTarget::sse4:
        wanted = HWY_SSE4;
        break;
    case BatchTarget::avx2:
        wanted = HWY_AVX2;
        break;
    case BatchTarget::avx512:
        wanted = HWY_AVX3;
        break;
#endif
    default:
        break;
    }
    hwy::SetSupportedTargetsForTest(0);
    const bool best = target == BatchTarget::best;
    const bool known = best || (wanted != 0 && (hwy::SupportedTargets() & (HWY_TARGETS)&wanted) != 0);
    if (known && !best) {
        hwy::SetSupportedTargetsForTest(wanted);
    }
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    return known;
}

} // namespace alpenglow::sh
