"""What is possible but unusual for a seed: a question in words beside the result, never a refusal."""

from vision.evidence.keys import Seed

USUAL_MM = (0.2, 60.0)  # a poppy seed; a coconut is larger, and asked about
USUAL_G = (1e-5, 100.0)
USUAL_KG_M3 = (150.0, 12_000.0)  # of balls too: cork to lead


def questions(seed: Seed) -> list[str]:
    """One sentence for the first size, and for the mass and the density, that no usual seed has."""
    asked = []
    sizes = [s for s in (seed.length_mm, seed.width_mm, seed.thickness_mm) if s]
    odd = [s for s in sizes if not USUAL_MM[0] <= s <= USUAL_MM[1]]
    if odd:
        asked.append(f"a seed of {odd[0]:,g} mm: is it in millimetres? It is taken as stated")
    if seed.mass_g and not USUAL_G[0] <= seed.mass_g <= USUAL_G[1]:
        asked.append(f"a seed of {seed.mass_g:,g} g: is it in grams? It is taken as stated")
    volume = 0.5236e-3 * sizes[0] * sizes[1] * sizes[2] if len(sizes) == 3 else None  # cm³
    density = seed.density_kg_m3 or (1000 * seed.mass_g / volume if seed.mass_g and volume else None)
    if density and not USUAL_KG_M3[0] <= density <= USUAL_KG_M3[1] and not seed.inertia_factor:
        asked.append(f"sizes and mass make {density:,.3g} kg/m³: are both right? A hollow ball has an [seed] inertia_factor of its own")
    return asked
