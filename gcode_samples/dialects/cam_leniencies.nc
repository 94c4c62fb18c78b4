g17 g21 g90 g0 x0 y0 f100
g1 x1.5e-3 y-2.5E+1
g2 x10 y-25 i5 j0 k0
g0 g28 z0
g1 x1
