#pragma once

#include <cstdint>
#include <vector>

#include "backends/embedded/bodies.h"
#include "backends/embedded/contact_lists.h"
#include "backends/embedded/neighbours.h"
#include "backends/embedded/particle_store.h"

namespace powdercal::embedded {

/// The contacts of all particles with one mesh: candidates from the last rebuild, contacts found
/// anew in every step, histories handed from one step to the next by particle and nearest normal,
/// so that they pass from face to edge to face as a particle moves along.
class MeshContacts {
 public:
  explicit MeshContacts(HistoryKinds kinds) : kinds_(kinds) {}

  /// Finds the candidates within radius + skin [m] after the particles were sorted; a particle near
  /// a periodic side meets the mesh's images as well.
  void Rebuild(const ParticleStore& particles, const TriangleMesh& surface, const Box& box,
               const Images& images, const std::vector<Slab>& slabs, double skin);

  /// Adds the contact forces of a slab's particles to their loads and the force on the mesh to
  /// `force`. Slabs may be worked on at the same time.
  void AddForces(std::size_t slab, std::int32_t padding_row, ParticleStore& particles,
                 const MeshBody& body, SurfaceKernel kernel, Vector3* force);

  /// Calls visit(overlap [m], radius [m]) for each contact of the last step.
  template <typename Visit>
  void ForEachContact(const Visit& visit) const {
    for (const SlabContacts& slab : slabs_) {
      for (const Remembered& contact : slab.memory) visit(contact.overlap, contact.radius);
    }
  }

 private:
  struct Near {  // a particle, or its image, near the mesh
    std::int32_t particle = 0;
    Vector3 shift{};          // [m] of the image
    std::uint32_t begin = 0;  // of its candidates
    std::uint32_t end = 0;
  };
  struct Remembered {
    std::int32_t particle = 0;
    std::int64_t id = 0;  // of the particle
    Vector3 normal{};
    double overlap = 0;  // [m]
    double radius = 0;   // [m] of the particle
    Vector3 shear{};
    Vector3 rolling{};
    bool taken = false;
  };
  struct SlabContacts {
    std::vector<Near> near;
    std::vector<Remembered> memory;  // in the order of the particles
    ContactList list;
    std::array<AlignedVector<double>, 3> normal;
    AlignedVector<double> distance;
    std::array<AlignedVector<double>, 3> velocity;
    std::vector<MeshContact> found;        // of one image
    std::vector<MeshContact> of_particle;  // of all its images
    std::vector<std::int32_t> particle;
    std::vector<MeshContact> contacts;
  };

  void FindContacts(SlabContacts& slab, const ParticleStore& particles, const MeshBody& body);
  void Recall(SlabContacts& slab);
  void Remember(SlabContacts& slab, const ParticleStore& particles);

  HistoryKinds kinds_;
  std::vector<Candidate> candidates_;
  std::vector<SlabContacts> slabs_;
};

}  // namespace powdercal::embedded
