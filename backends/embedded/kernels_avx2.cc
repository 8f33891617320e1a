#define POWDERCAL_ISA avx2
#include "backends/embedded/contact_kernels.inc"

namespace powdercal::embedded {

extern const KernelTable kAvx2Kernels;
const KernelTable kAvx2Kernels = avx2::MakeTable();

}  // namespace powdercal::embedded
